"""Code that somebody else could have put on disk is not run, and a sentence says why."""

import os
import warnings

import pytest

from fastdyn import code_store
from fastdyn.code_store import cache, object_file
from fastdyn.code_store.folders import folders, trust
from fastdyn.code_store.target import translated

KEY = "a key of these tests"
OURS, PLANTED = 41, 13
OTHER = 12345  # a user
CODE = "define i64 @{symbol}(ptr %words) {{ ret i64 {value} }}\n"
root_only = pytest.mark.skipif(
    getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away"
)
pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes are POSIX's")


def entry(value):
    """(name, bytes) of an entry of KEY whose code answers `value`."""
    symbol = cache._symbol(KEY)
    code, needs = translated(CODE.format(symbol=symbol, value=value), symbol)
    header = {"symbol": symbol, "needs": needs, "arguments": []}
    return cache._file(symbol), object_file.packed(header, code)


def answer():
    """What the code of KEY answers, of whichever origin."""
    code = code_store.assembled(KEY, lambda symbol: CODE.format(symbol=symbol, value=OURS))
    return code_store.Call(code)()


@pytest.fixture(params=["system", "own"])
def place(request, tmp_path, monkeypatch):
    """An entry that is not ours, in a folder that is read, below one of ours: `place.file`."""
    above = tmp_path / "above"
    folder = above / "folder" / "fastdyn"
    folder.mkdir(parents=True)
    for path in (above, above / "folder", folder):
        path.chmod(0o755)
    monkeypatch.setenv("FASTDYN_SHARED_CODE", str(folder) if request.param == "system" else "")
    own = above / "folder" if request.param == "own" else tmp_path / "own"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(own))
    environment = cache.environment(cache.FUNCTIONS)
    monkeypatch.setattr(cache, "environment", lambda made_by: environment)  # which keeps a hash
    folders._say.cache_clear()
    name, data = entry(PLANTED)
    file = folder / name
    file.write_bytes(data)
    file.chmod(0o644)
    yield file
    folders._say.cache_clear()


def test_the_planted_entry_works_where_it_is_trusted(place):
    assert answer() == PLANTED


def of_another_user(path):
    os.chown(path, OTHER, OTHER)


def mode(bits):
    return lambda path: path.chmod(bits)


def by_a_link(path):
    path.rename(path.with_name(f"{path.name} moved"))
    path.symlink_to(path.with_name(f"{path.name} moved"))


def by_a_link_of_another_user(path):
    by_a_link(path)
    os.chown(path, OTHER, OTHER, follow_symlinks=False)


def a_folder(path):
    path.unlink()
    path.mkdir()


OTHERS_CAN_WRITE = [mode(bits) for bits in (0o666, 0o664, 0o646, 0o777)]
PLANTS = {
    # what is done, to what, what is said
    **{f"file {i}": (f, 0, "others can write to an entry") for i, f in enumerate(OTHERS_CAN_WRITE)},
    "linked file": (by_a_link, 0, "an entry is a symbolic link"),
    "folder as a file": (a_folder, 0, "an entry is no file"),
    **{f"folder {i}": (f, 1, "others can write to it; `chmod go-w`")
       for i, f in enumerate([*OTHERS_CAN_WRITE, mode(0o1777), mode(0o775), mode(0o757)])},
    "linked folder": (by_a_link, 1, "it is a symbolic link; give the folder that"),
    **{f"above {i}": (f, at, r"others can write to .*, and so exchange it; `chmod")
       for i, f in enumerate([mode(0o777), mode(0o775), mode(0o757)]) for at in (2, 3)},
}  # fmt: skip
OF_ANOTHER_USER = {
    "file": (of_another_user, 0, "an entry belongs to another user"),
    "linked file": (by_a_link_of_another_user, 0, "an entry is a symbolic link"),
    "folder": (of_another_user, 1, "it belongs to another user"),
    "above": (of_another_user, 2, ".* belongs to another user, who can exchange what lies in it"),
    "far above": (of_another_user, 3, ".* belongs to another user, who can exchange"),
    "link above": (by_a_link_of_another_user, 2, "the link .* belongs to another user"),
}


def up(file, n):
    return [file, *file.parents][n]


@pytest.mark.parametrize("first", ["at once", "after a first use"])
@pytest.mark.parametrize("plant", PLANTS)
def test_what_others_can_change_is_not_run(place, plant, first):
    done, at, sentence = PLANTS[plant]
    if first != "at once":
        assert answer() == PLANTED  # nothing that was trusted once is trusted for ever
    done(up(place, at))
    with pytest.warns(UserWarning, match=f"compiled code in .* is not used: {sentence}"):
        assert answer() == OURS
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is said once
        assert answer() == OURS


@root_only
@pytest.mark.parametrize("first", ["at once", "after a first use"])
@pytest.mark.parametrize("plant", OF_ANOTHER_USER)
def test_what_belongs_to_others_is_not_run(place, plant, first):
    done, at, sentence = OF_ANOTHER_USER[plant]
    if first != "at once":
        assert answer() == PLANTED
    done(up(place, at))
    with pytest.warns(UserWarning, match=f"compiled code in .* is not used: {sentence}"):
        assert answer() == OURS


@root_only
def test_a_folder_that_is_exchanged_after_its_first_use_is_not_read(place):
    folder = place.parent
    assert answer() == PLANTED
    folder.rename(folder.with_name("before"))
    folder.mkdir()
    place.write_bytes(entry(PLANTED)[1])
    of_another_user(folder)
    with pytest.warns(UserWarning, match="it belongs to another user"):
        assert answer() == OURS


def test_a_pipe_in_the_place_of_an_entry_is_no_wait(place):
    place.unlink()
    os.mkfifo(place, 0o644)
    with pytest.warns(UserWarning, match="an entry is no file"):
        assert answer() == OURS


def test_an_own_entry_that_others_can_write_is_replaced(place):
    if not os.environ["NUMBA_CACHE_DIR"] == str(place.parents[1]):
        pytest.skip("the system's folder is only read")
    place.chmod(0o666)
    with pytest.warns(UserWarning, match="others can write to an entry"):
        assert answer() == OURS
    assert place.stat().st_mode & 0o777 == 0o644
    made = code_store.COUNTS["compiled"]
    assert answer() == OURS and code_store.COUNTS["compiled"] == made


def test_sticky_folders_and_own_links_above_are_no_reason(place):
    up(place, 3).chmod(0o1777)  # as /tmp
    assert answer() == PLANTED
    folder = up(place, 2)
    by_a_link(folder)
    assert answer() == PLANTED
    folder.unlink()
    folder.symlink_to(f"../above/./{folder.name} moved/../{folder.name} moved")
    assert answer() == PLANTED
    folder.unlink()
    folder.symlink_to(folder)  # to itself
    assert answer() == OURS


@root_only
def test_a_group_of_the_user_alone_may_write_above(place, monkeypatch):
    """The umask 002 of many systems; nobody else is in such a group."""
    import grp
    import pwd

    for path in (place, *place.parents[:3]):
        of_another_user(path)
    up(place, 2).chmod(0o775)
    user = pwd.struct_passwd(("ann", "x", OTHER, OTHER, "", "/nowhere", ""))
    members = []
    monkeypatch.setattr(os, "geteuid", lambda: OTHER)
    monkeypatch.setattr(pwd, "getpwuid", lambda uid: user)
    monkeypatch.setattr(grp, "getgrgid", lambda g: grp.struct_group(("ann", "x", g, members)))
    trust._is_private.cache_clear()
    try:
        assert answer() == PLANTED
        members.append("bob")
        trust._is_private.cache_clear()
        with pytest.warns(UserWarning, match="others can write to"):
            assert answer() == OURS
    finally:
        trust._is_private.cache_clear()


@root_only
def test_what_lies_above_the_home_is_not_asked(place, monkeypatch):
    """A sandbox may show all folders of the system as those of somebody else."""
    of_another_user(up(place, 3))
    monkeypatch.setattr(trust, "_home", lambda user: str(up(place, 2)))
    assert answer() == PLANTED
    with pytest.raises(trust.Doubt):  # a way that leaves the home is asked from the root on
        trust.check_above(f"{up(place, 2)}/../{up(place, 2).name}/fastdyn")
    monkeypatch.setattr(trust, "_home", lambda user: str(up(place, 2)) + "x")
    with pytest.warns(UserWarning, match="who can exchange what lies in it"):
        assert answer() == OURS
