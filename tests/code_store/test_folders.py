"""Folders of kept code: the system's first, then the user's; one that fails is no error."""

import errno
import os
import random
import subprocess
import sys

import pytest

from fastdyn import code_store
from fastdyn.code_store import cache, object_file, precompiled
from fastdyn.code_store.folders import folder, folders, trust
from fastdyn.code_store.key import sources

TEXT = "define i64 @{0}(ptr %words) {{ ret i64 41 }}\n"


@pytest.fixture
def places(tmp_path, monkeypatch):  # the folders of the system and of the user
    system = tmp_path / "system"
    system.mkdir(mode=0o755)
    monkeypatch.setenv("FASTDYN_SHARED_CODE", str(system))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "user"))
    return system, tmp_path / "user" / "fastdyn"


def made():
    """How many pieces of code a call of `assembled` made."""
    before = code_store.COUNTS["compiled"]
    code_store.assembled("a key of this test", TEXT.format)
    return code_store.COUNTS["compiled"] - before


def test_the_folder_of_the_system_serves_users_that_have_nothing(places):
    system, user = places
    assert made() == 1 and made() == 0
    (entry,) = user.glob("*.o")
    entry.rename(system / entry.name)
    assert made() == 0 and not list(user.glob("*.o"))  # and what is read only is not written


WITHOUT_A_HOME = """
import pwd
def nobody(user):
    raise KeyError(user)
pwd.getpwuid = nobody
import fastdyn
result = fastdyn.solve_ivp(lambda t, y: [-y[0]], (0, 1), [1.0])
print(result.status, fastdyn.code_store.COUNTS)
"""


def test_without_a_home_nothing_is_kept_and_all_works(tmp_path):
    shared = os.environ["NUMBA_CACHE_DIR"]
    unset = ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR", "MPLCONFIGDIR")
    given = {name: value for name, value in os.environ.items() if name not in unset}
    given["FASTDYN_SHARED_CODE"] = os.path.join(shared, "fastdyn")
    command = [sys.executable, "-W", "error", "-c", WITHOUT_A_HOME]
    done = subprocess.run(command, env=given, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0 {") and "'stored': 0" in done.stdout
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fails", ["write", "replace"])
def test_a_full_disk_leaves_nothing_half_written(places, fails, monkeypatch):
    def full(*given, **more):
        raise OSError(errno.ENOSPC, "No space left on device")

    class Full:
        def __init__(self, descriptor, how):
            self.descriptor = descriptor

        def __enter__(self):
            return self

        def __exit__(self, *failure):
            os.close(self.descriptor)

        write = full

    fakes = {"write": ("fdopen", Full), "replace": ("replace", full)}
    with monkeypatch.context() as patch:
        patch.setattr(folder.os, *fakes[fails])
        assert made() == 1
    assert list(places[1].iterdir()) == []
    assert made() == 1 and made() == 0


def test_what_killed_processes_left_goes_and_what_is_being_written_stays(places):
    user = places[1]
    assert made() == 1
    old, new = user / "1.tmp", user / "2.tmp"
    for file, age in ((old, 2 * folder.HOUR), (new, 0.0)):
        file.write_bytes(b"half")
        at = file.stat().st_mtime - age
        os.utime(file, (at, at))
    with folder.Folder(str(user)) as opened:
        opened.prune(folders.MAX_FILES, folders.MAX_BYTES)
    assert not old.exists() and new.exists() and made() == 0


def test_what_is_used_is_not_longest_unused(places):
    user = places[1]
    assert made() == 1
    (entry,) = user.glob("*.o")
    before = entry.stat().st_mtime - 2 * folder.NOTED  # within a run of many tests
    os.utime(entry, (before, before))
    assert made() == 0
    assert entry.stat().st_mtime > before + folder.NOTED


def test_folders_are_made_for_all_to_read_whatever_the_umask(places):
    user = places[1]
    before = os.umask(0)
    try:
        assert made() == 1
    finally:
        os.umask(before)
    (entry,) = user.glob("*.o")
    modes = [path.stat().st_mode & 0o777 for path in (user.parent, user, entry)]
    assert modes == [0o755, 0o755, 0o644] and made() == 0


def test_a_folder_that_another_process_makes_meanwhile_is_no_failure(places, monkeypatch):
    mkdir = os.mkdir

    def late(path, mode):
        mkdir(path, mode)
        mkdir(path, mode)  # raises FileExistsError

    monkeypatch.setattr(trust.os, "mkdir", late)
    before = code_store.COUNTS["stored"]
    assert made() == 1 and made() == 0 and code_store.COUNTS["stored"] == before + 1


def kept(header, code):
    """Keep an entry of the key, with a hash that is right."""
    name = cache._file(cache._symbol("a key of this test"))
    assert folders.store(name, object_file.packed(header, code))


HEADERS = {
    "empty": lambda h: {},
    "a list": lambda h: [1],
    "no arguments": lambda h: {k: v for k, v in h.items() if k != "arguments"},
    "no needs": lambda h: {k: v for k, v in h.items() if k != "needs"},
    "no symbol": lambda h: {k: v for k, v in h.items() if k != "symbol"},
    "another symbol": lambda h: {**h, "symbol": "fastdyn_other"},
    "needs None": lambda h: {**h, "needs": None},
    "needs a number": lambda h: {**h, "needs": [1]},
    "other needs": lambda h: {**h, "needs": ["sin"]},
    "an argument alone": lambda h: {**h, "arguments": ["y"]},
    "an argument without a kind": lambda h: {**h, "arguments": [["y"]]},
    "an argument of numbers": lambda h: {**h, "arguments": [[1, 2]]},
    "an argument of no dimension": lambda h: {**h, "arguments": [["y", "<f8:x"]]},
}


@pytest.mark.parametrize("change", HEADERS)
def test_a_broken_header_with_a_right_hash_is_made_again(places, change):
    assert made() == 1
    symbol = cache._symbol("a key of this test")
    (data,) = folders.entries(cache._file(symbol))
    header, code = object_file.unpacked(data, symbol)
    kept(HEADERS[change](header), code)
    assert made() == 1 and made() == 0


def test_entries_broken_at_random_with_a_right_hash_are_refused_or_whole(places):
    assert made() == 1
    symbol = cache._symbol("a key of this test")
    (data,) = folders.entries(cache._file(symbol))
    begin = len(object_file.MAGIC) + object_file.DIGEST
    draw = random.Random(1)
    refused = 0
    for _ in range(3000):
        rest = bytearray(data[begin:])
        for _ in range(draw.randint(1, 4)):
            rest[draw.randrange(len(rest))] = draw.choice([0, 1, 0x7F, 0x80, 0xFF])
        rest = bytes(rest[: draw.choice([len(rest), draw.randrange(len(rest))])])
        digest = object_file.hashlib.sha256(rest).digest()
        try:
            object_file.unpacked(object_file.MAGIC + digest + rest, symbol)
        except object_file.NotWhole:
            refused += 1
    assert refused > 1000


def test_code_that_does_not_link_is_made_again(places, monkeypatch):
    assert made() == 1
    from fastdyn.code_store import loader

    def broken(self, *given):
        raise RuntimeError("LLVM says no")

    with monkeypatch.context() as patch:
        patch.setattr(loader.llvm.JITLibraryBuilder, "link", broken)
        assert cache.stored("a key of this test") is None
    assert made() == 0


@pytest.mark.parametrize("damaged", [b"\xff" * 128, b"0" * 64, b"0" * 128, b""])
def test_a_damaged_hash_of_the_sources_is_found_anew(places, damaged):
    sources._hashes.cache_clear()
    known = sources._hashes(sources.OF_KERNELS)
    (entry,) = places[1].glob("*.sources")
    whole = entry.read_bytes()
    entry.write_bytes(damaged)
    sources._hashes.cache_clear()
    assert sources._hashes(sources.OF_KERNELS) == known and entry.read_bytes() == whole


def test_what_comes_compiled_is_loaded_and_what_is_damaged_is_not(places, tmp_path, monkeypatch):
    level = precompiled.best_level()
    if level is None:
        pytest.skip("no files are made for this system")
    monkeypatch.setattr(precompiled, "OBJECTS", tmp_path / "objects")
    precompiled.level.cache_clear()
    symbol = precompiled.symbol_of("a key of this test", code_store.KERNELS, level)
    from fastdyn.code_store.target import translated

    code, needs = translated(TEXT.format(symbol), symbol)
    header = {"symbol": symbol, "needs": needs, "arguments": []}
    data = object_file.packed(header, code)
    file = tmp_path / "objects" / level / f"{symbol.removeprefix('fastdyn_')}.o"
    file.parent.mkdir(parents=True)
    try:
        file.write_bytes(data)
        precompiled.level.cache_clear()
        found = cache.stored("a key of this test", code_store.KERNELS)
        assert (found is not None) == (precompiled.level() is not None)
        assert found is None or code_store.Call(found)() == 41
        assert cache.stored("a key of this test") is None  # of a function, which never comes
        file.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
        assert cache.stored("a key of this test", code_store.KERNELS) is None
    finally:
        precompiled.level.cache_clear()
