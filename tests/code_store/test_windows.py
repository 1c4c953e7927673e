"""The branches for Windows of paths, locks and permissions, run here."""

import os
import types

import pytest

from fastdyn import code_store
from fastdyn.code_store import one_at_a_time
from fastdyn.code_store.folders import folder, folders, trust

TEXT = "define i64 @{0}(ptr %words) {{ ret i64 41 }}\n"


@pytest.fixture
def profile(tmp_path, monkeypatch):
    """The profile of a user of Windows: no descriptors of folders, no owners."""
    monkeypatch.setattr(folder, "POSIX", False)
    monkeypatch.setattr(folders, "POSIX", False)
    monkeypatch.setattr(folder, "PLAIN", 0)
    for name in ("O_NOFOLLOW", "O_DIRECTORY", "geteuid"):
        monkeypatch.delattr(folder.os, name)
    home = tmp_path / "user"
    monkeypatch.setenv("HOME", str(home))  # USERPROFILE
    monkeypatch.setenv("LOCALAPPDATA", str(home / "local"))
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("FASTDYN_SHARED_CODE", "")
    folders._say.cache_clear()
    return home


def made():
    before = code_store.COUNTS["compiled"]
    code_store.assembled("a key of the test of Windows", TEXT.format)
    return code_store.COUNTS["compiled"] - before


def test_code_is_kept_in_the_profile(profile):
    assert made() == 1 and made() == 0
    place = profile / "local/numba/fastdyn"
    assert len(list(place.glob("*.o"))) == 1
    with folder.Folder(str(place), make=True) as opened:
        opened.prune(0, 0)
    assert made() == 1


def test_a_folder_outside_is_refused(profile, tmp_path, monkeypatch):
    assert made() == 1
    outside = tmp_path / "user2"  # as a text it begins with the profile
    (profile / "local/numba/fastdyn").rename(outside)
    monkeypatch.setenv("FASTDYN_SHARED_CODE", str(outside))
    with pytest.warns(UserWarning, match=r"user2 is not used: it is not in the user's profile"):
        assert made() == 1


def test_a_link_that_leads_out_is_refused(profile, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (profile / "local/numba").mkdir(parents=True)
    (profile / "local/numba/fastdyn").symlink_to(tmp_path / "elsewhere")
    with pytest.warns(UserWarning, match="not in the user's profile"):
        assert made() == 1
    assert not list((tmp_path / "elsewhere").iterdir())


def test_the_folder_of_the_system_is_refused_if_anybody_has_made_one(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "user"))
    with pytest.raises(trust.Doubt, match="profile"):
        trust.check_in_profile(str(tmp_path / "var/cache/fastdyn"))
    with pytest.raises(trust.Doubt, match="profile"):
        trust.check_in_profile(str(tmp_path / "user"))  # whose name others may be able to change
    trust.check_in_profile(str(tmp_path / "user/cache"))


class Locking:
    """msvcrt.locking: one byte of an open file; a held lock is a PermissionError."""

    LK_NBLCK, LK_UNLCK = 2, 0

    def __init__(self):
        self.held, self.refusals = False, 0

    def locking(self, file, mode, n):
        assert n == 1 and os.lseek(file, 0, os.SEEK_CUR) == 0
        if mode == self.LK_UNLCK:
            self.held = False
        elif self.held:
            self.refusals += 1
            if self.refusals == 3:
                self.held = False  # the holder ends
            raise PermissionError(13, "Permission denied")
        else:
            self.held = True


def test_a_lock_is_waited_for(profile, monkeypatch):
    msvcrt = Locking()
    monkeypatch.setattr(one_at_a_time, "fcntl", None)
    monkeypatch.setattr(one_at_a_time, "msvcrt", msvcrt)
    msvcrt.held = True
    with one_at_a_time.alone("entry"):
        assert msvcrt.held and msvcrt.refusals == 3
    assert not msvcrt.held


def test_without_any_lock_nobody_waits(profile, monkeypatch):
    monkeypatch.setattr(one_at_a_time, "fcntl", None)
    monkeypatch.setattr(one_at_a_time, "msvcrt", None)
    with one_at_a_time.alone("entry"):
        assert not list(profile.rglob("*.lock"))


def test_an_open_file_of_a_lock_stays(profile, monkeypatch):
    def unlink(path, **options):
        raise PermissionError(13, "used by another process")

    monkeypatch.setattr(one_at_a_time, "os", types.SimpleNamespace(**vars(os) | {"unlink": unlink}))
    with one_at_a_time.alone("entry"):
        pass
    assert len(list(profile.rglob("entry.lock"))) == 1
