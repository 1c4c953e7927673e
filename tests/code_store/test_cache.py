"""Compiled code on disk, seen from fresh processes."""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import fastdyn
import fastdyn.kernels

SCRIPT = """
import fastdyn, numpy as np, {helper}
def fun(t, y, k):
    x, v = y
    return np.array([v, {helper}.force(x) * k])
r = fastdyn.solve_ivp(fun, (0, 5), [1.0, 0.0], "RK23", args=(2.0,), compile={compile!r})
if {vehicle}:
    fastdyn.systems.vehicle().solve((0, 1), method="RK23")  # a function among its args
print(r.nfev, r.y[0, -1].hex(), fastdyn.code_store.COUNTS["compiled"])
"""


def copy_if_there(source, target):
    """Another worker may have dropped an old entry meanwhile."""
    with contextlib.suppress(FileNotFoundError):
        shutil.copy2(source, target)


class Place:
    """A folder with a script, a module that it imports, and a cache.

    The cache has the kernels that all tests share, and none of what a script adds; also for a copy
    of the package at `path`, as long as it is one.
    """

    def __init__(self, folder, compile="shared", path=None):
        self.folder, self.cache = folder, folder / "cache"
        self.shared = pathlib.Path(os.environ["NUMBA_CACHE_DIR"], "fastdyn")
        if self.shared.is_dir():
            shutil.copytree(
                self.shared, self.cache / "fastdyn", copy_function=copy_if_there,
                ignore=shutil.ignore_patterns("*.tmp"),
            )  # fmt: skip
        self.given = set(self.files())
        self.script = folder / "script.py"
        self.script.write_text(
            SCRIPT.format(helper="springs", compile=compile, vehicle=path is None)
        )
        self.module("return -1.0625 * x")
        self.path = path

    def module(self, body):
        (self.folder / "springs.py").write_text(f"def force(x):\n    {body}\n")

    def start(self, cache=None):
        paths = [str(p) for p in (self.path, self.folder) if p]
        environment = os.environ | {
            "NUMBA_CACHE_DIR": str(cache or self.cache),
            "PYTHONPATH": os.pathsep.join(paths),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        command = [sys.executable, "-W", "error", str(self.script)]
        return subprocess.Popen(
            command, env=environment, cwd=self.folder, text=True, stdout=subprocess.PIPE
        )

    def run(self, cache=None):
        process = self.start(cache)
        out, _ = process.communicate()
        assert process.returncode == 0
        nfev, last, compiled = out.split()
        return int(nfev), float.fromhex(last), int(compiled)

    def files(self):
        return sorted(p.name for p in (self.cache / "fastdyn").glob("*"))


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    place = Place(tmp_path_factory.mktemp("filled"), "inlined")
    return place, place.run()


@pytest.mark.hunt
def test_a_second_process_compiles_nothing_and_adds_no_file(filled):
    place, first = filled
    files = place.files()
    assert first[2] > 0 and place.run() == (*first[:2], 0) and place.files() == files


def test_an_edit_to_a_called_function_is_seen(filled):
    place, first = filled
    place.module("return -2.125 * x")
    try:
        changed = place.run()
        assert changed[2] > 0 and changed[1] != first[1]
    finally:
        place.module("return -1.0625 * x")
    assert place.run() == (*first[:2], 0)


def test_damaged_entries_are_made_again(filled):
    place, first = filled
    made = sorted(set(place.files()) - place.given)
    assert len(made) > 2
    for i, name in enumerate(made):
        path = place.cache / "fastdyn" / name
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2] if i % 2 else data[:-1] + bytes([data[-1] ^ 1]))
    assert place.run()[:2] == first[:2]
    assert place.run() == (*first[:2], 0)


def test_without_a_place_to_write_it_still_works(filled, monkeypatch):
    place, first = filled
    nowhere = place.folder / "file"
    nowhere.write_text("")
    monkeypatch.setenv("FASTDYN_SHARED_CODE", str(place.shared))  # kernels, only to be read
    found = place.run(cache=nowhere / "below")
    assert found[:2] == first[:2] and found[2] > 0


def test_two_processes_fill_one_cache_at_once(tmp_path):
    place = Place(tmp_path)
    both = [place.start(), place.start()]
    answers = [p.communicate()[0].split()[:2] for p in both]
    assert all(p.returncode == 0 for p in both) and answers[0] == answers[1]
    assert not [name for name in place.files() if name.endswith(".tmp")]
    assert place.run()[2] == 0


@pytest.mark.hunt
def test_an_edit_to_a_kernel_is_seen(tmp_path):
    package = tmp_path / "copy" / "fastdyn"
    shutil.copytree(pathlib.Path(fastdyn.__file__).parent, package)
    kernels = pathlib.Path(fastdyn.kernels.__file__).parent
    shutil.copytree(kernels, package / "kernels", dirs_exist_ok=True)
    (tmp_path / "work").mkdir()
    place = Place(tmp_path / "work", path=package.parent)
    first = place.run()
    for folder, makes_code in (("plot", False), ("trace", True)):
        file = package / folder / "__init__.py"
        file.write_text(file.read_text() + "# a comment\n")
        assert (place.run()[2] > 0) == makes_code
    control = package / "kernels" / "stepping" / "step_size.py"
    known, other = "SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9", "SAFETY, MIN_FACTOR, MAX_FACTOR = 0.5"
    assert known in control.read_text()
    control.write_text(control.read_text().replace(known, other))
    assert place.run()[0] > first[0]


def test_old_entries_go(tmp_path):
    from fastdyn.code_store.folders.folder import Folder

    for i in range(30):
        path = tmp_path / f"{i}.o"
        path.write_bytes(b"x" * 10)
        os.utime(path, (i, i))
    with Folder(str(tmp_path)) as folder:
        folder.prune(10, 2**20)
    assert {p.stem for p in tmp_path.iterdir()} == {str(i) for i in range(20, 30)}
