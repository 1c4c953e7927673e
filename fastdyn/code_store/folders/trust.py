"""The check that nobody else can change or exchange a file of kept code.

Code that is read from disk runs.  So its file, the folder and each folder above must belong to the
user or to the system's owner, and nobody else may write to them: OpenSSH demands this of the files
that grant access (`auth_secure_path`).  Every read checks anew.  On Windows the folder must be in
the user's profile.
"""

import contextlib
import errno
import functools
import os
import stat

POSIX = os.name == "posix"
OTHERS = stat.S_IWGRP | stat.S_IWOTH
MAX_LINKS = 40  # as Linux


class Doubt(Exception):
    """Others could change a file or folder; the text says why."""


def check(found, name="it"):
    """Raise Doubt if others can write to a file or folder with the stat `found`."""
    if found.st_uid not in (0, os.geteuid()):
        raise Doubt(f"{name} belongs to another user")
    if found.st_mode & OTHERS:  # with an access control list, the bits of the group are its mask
        raise Doubt(f"others can write to {name}; `chmod go-w` it")


def check_in_profile(path):
    """Raise Doubt if a folder is not in the profile of the user, for Windows.

    Windows lets nobody write to a profile but the user and administrators.  Python shows no lists
    of access: folders elsewhere, which anybody may be allowed to write, are refused.
    """
    profile, folder = (
        os.path.normcase(os.path.realpath(each)) for each in (os.path.expanduser("~"), path)
    )
    if not folder.startswith(os.path.join(profile, "")):
        raise Doubt("it is not in the user's profile, and others may write to it")


def check_above(path, make=False):
    """The stat of a folder, by a path that nobody else can change; raises Doubt if others can.

    From the root downwards, each folder is checked before a name in the folder is looked up: a
    checked folder can no longer be exchanged.  A folder above the user's home may fail the check:
    its owner controls the user's account, and all files that Python reads at its start.

    Parameters
    ----------
    path : str
        An absolute path.
    make : bool
        Make missing folders, readable by all.
    """
    try:
        return _passed("", path, make)
    except Doubt:
        home = _home(os.geteuid())
        if home is None or not path.startswith(f"{home}/"):
            raise
    return _passed(home, path.removeprefix(home), make)


def _passed(at, path, make):
    """The stat of the folder at the end of `path`, which begins in the folder `at` ("" for "/")."""
    trusted = (0, os.geteuid())
    names = path.split("/")[::-1]
    n_links = 0
    found = os.lstat(at or "/")
    while names:
        name = names.pop()
        if name in ("", "."):
            continue
        if found.st_uid not in trusted or found.st_mode & OTHERS:
            _check_holder(at or "/", found)
        if name == "..":  # the name may lead above the beginning
            names += os.path.dirname(at).split("/")[::-1]
            at = ""
            found = os.lstat("/")
            continue
        below = f"{at}/{name}"
        found = _seen(below, make)
        if not stat.S_ISLNK(found.st_mode):
            at = below
            continue
        if found.st_uid not in trusted:
            raise Doubt(f"the link {below} belongs to another user")
        n_links += 1
        if n_links > MAX_LINKS:
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), below)
        target = os.readlink(below)
        names += target.split("/")[::-1]
        at = "" if target.startswith("/") else at
        found = os.lstat(at or "/")
    return found


def _seen(path, make):
    try:
        return os.lstat(path)
    except FileNotFoundError:
        if not make:
            raise
        with contextlib.suppress(FileExistsError):  # another process was faster
            os.mkdir(path, 0o755)
        return os.lstat(path)


def _check_holder(path, found):
    """Raise Doubt if others could exchange files in a folder.

    With the sticky bit, as in /tmp, nobody can rename or delete the files of somebody else.
    """
    if found.st_uid not in (0, os.geteuid()):
        raise Doubt(f"{path} belongs to another user, who can exchange what lies in it")
    others = found.st_mode & OTHERS and not found.st_mode & stat.S_ISVTX
    if others and not (not found.st_mode & stat.S_IWOTH and _only_the_user(path, found.st_gid)):
        raise Doubt(f"others can write to {path}, and so exchange it; `chmod go-w` that")


def _only_the_user(path, group):
    """True if the group that can write to a folder has the user as its only member.

    Many systems give each user a group of the user's name, which may write (umask 002).
    """
    try:
        listed = "system.posix_acl_access" in os.listxattr(path, follow_symlinks=False)
    except (AttributeError, OSError):
        listed = False
    return not listed and _is_private(group, os.geteuid())


@functools.lru_cache(64)
def _is_private(group, user):
    import grp
    import pwd

    try:
        person = pwd.getpwuid(user)
        found = grp.getgrgid(group)
    except KeyError:
        return False
    same = user != 0 and group == person.pw_gid and found.gr_name == person.pw_name
    return same and set(found.gr_mem) <= {person.pw_name}


@functools.lru_cache(64)
def _home(user):
    """The real path of a user's home, from the system and not from HOME; None without a home."""
    import pwd

    try:
        home = os.path.realpath(pwd.getpwuid(user).pw_dir)
    except (KeyError, OSError):
        return None
    return None if home == "/" else home
