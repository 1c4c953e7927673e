"""Which sources a key covers: those that can change the code, and no others.  Needs no Numba.

The code of users' functions depends on the folders of the compiler, all of them, and on the modules
of kernels that the compiler imports.  A kernel depends on the modules from which the kernel is
made, and on all that these modules import, at any depth, also within functions.  Modules that tell
Numba something that holds for the whole process, as `overload` does, count for all code.
"""

import functools
import hashlib
import json
import os
import pathlib
from typing import NamedTuple

from ..folders import folders

PACKAGE = pathlib.Path(__file__).parents[2]
OBJECTS = PACKAGE / "code_store" / "objects"  # what a wheel brings beside the sources
SHIPPED = OBJECTS / "sources"
OF_KERNELS = frozenset({"kernels", "specialise", "code_store"})  # the folders that make kernels
# The folders that make no code.  A folder that is not named counts as one that makes the code of
# functions: a new folder is safe.  A test sees that these folders make none.
_WITHOUT = {
    "__pycache__", "analysis", "cli", "course", "dae", "delays", "derive", "drift", "ensemble",
    "explore", "fitting", "integrate", "matlab", "noise", "pages", "planets", "plot", "problem",
    "run", "solve", "systems", "words",
}  # fmt: skip
_MAKING = OF_KERNELS | {
    folder.name for folder in os.scandir(PACKAGE) if folder.is_dir() and folder.name not in _WITHOUT
}
# What a module of kernels may import from Numba, and change nothing outside itself.  A module that
# imports anything else from Numba counts for all code.
HARMLESS = {"carray", "cgutils", "config", "errors", "intrinsic", "numba", "types"}
WHOLE = ""  # the name of the hash of all files of the folders


class MadeBy(NamedTuple):
    """The sources that make code.

    Attributes
    ----------
    folders : frozenset of str
        Folders of fastdyn.  Outside `kernels`, each file of these folders counts.
    modules : tuple of str
        Modules of these folders whose imports count, from fastdyn on, as ``kernels.methods.rk45``;
        ``compile.*`` are all modules of a folder.
    """

    folders: frozenset
    modules: tuple

    def around(self, *modules):
        """These sources and the imports of more modules."""
        return self._replace(modules=self.modules + modules)

    @property
    def is_kernel(self):
        """True for code that contains no function of the user."""
        return self.folders == OF_KERNELS


KERNELS = MadeBy(OF_KERNELS, ("specialise.dispatchers",))
FUNCTIONS = MadeBy(_MAKING, tuple(f"{folder}.*" for folder in sorted(_MAKING - {"kernels"})))


@functools.cache
def sources(made_by):
    """The hash of the sources that make code, by name and content."""
    known = _hashes(made_by.folders)
    whole = known[WHOLE]  # for a module that is in none of these folders
    return hashlib.sha256(
        "".join(known.get(m, whole) for m in made_by.modules).encode()
    ).hexdigest()


@functools.cache
def _hashes(of_folders):
    """The hash of each module of kernels and all its imports, and of the common part.

    The hashes are kept under the stamps of the files: no file is read again before a stamp changes.
    The time of the last change of an inode cannot be set back.
    """
    found = sorted(_files(of_folders))
    stamp = _stamp(found)
    for data in folders.entries(f"{stamp}.sources"):
        known = data[64:]
        if data == _sealed(known, stamp):
            return json.loads(known)
    contents = _contents(found)
    known = _shipped(contents) or _computed(contents)
    if _stamp(found) == stamp:  # no file was edited meanwhile
        folders.store(f"{stamp}.sources", _sealed(json.dumps(known).encode(), stamp))
    return known


def _shipped(contents):
    """The hashes that a wheel brings; None if the files are not those that the wheel was made of.

    They save a first process 0.8 s: to read the imports of all files.
    """
    try:
        every = json.loads(SHIPPED.read_bytes())
    except OSError:
        return None
    whole = _digest(contents, _of_files(contents))
    return next((known for known in every if known[WHOLE] == whole), None)


def ship(*makers):
    """Write the hashes of the sources of each MadeBy for a wheel."""
    every = [_computed(_contents(_files(made_by.folders))) for made_by in makers]
    SHIPPED.write_text(json.dumps(every))


def _contents(found):
    """{name: bytes} of files."""
    return {name: pathlib.Path(entry.path).read_bytes() for name, entry in found}


def _of_files(contents):
    """The hash of each file, by name."""
    return {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}


def _sealed(known, stamp):
    """The kept form of hashes, with a check: a damaged hash would stand for other sources."""
    return hashlib.sha256(known + stamp.encode()).hexdigest().encode() + known


def _stamp(found):
    lines = []
    for _, entry in found:
        s = os.stat(entry.path)
        lines.append((entry.path, s.st_dev, s.st_ino, s.st_size, s.st_mtime_ns, s.st_ctime_ns))
    return hashlib.sha256(repr(lines).encode()).hexdigest()


def _computed(contents):
    """{module: hash} of each module in `MadeBy.modules`, from the contents of the files by name."""
    of_files = _of_files(contents)
    modules = {_module(name): name for name in contents if name.endswith(".py")}
    imported, for_all = {}, set()
    for module, name in modules.items():
        if name.split("/")[0] not in OF_KERNELS and b"kernels" not in contents[name]:
            imported[module] = set()  # of a folder whose modules all count
            continue
        names, changes_numba = _imports(module, name, contents[name])
        imported[module] = _known({module, *names}, modules)
        if changes_numba and module.startswith("kernels."):
            for_all.add(module)
    always = {name for name in contents if not name.startswith("kernels/")}
    tables = {name for name in contents if name.endswith(".json")}

    def digest(starts):
        reached = _reached(starts | for_all, imported)
        # A table of numbers lies beside the `__init__` of the package that reads the table.
        read = {name for name in tables if _module(name, of_folder=True) in reached}
        return _digest(always | read | {modules[module] for module in reached}, of_files)

    known = {WHOLE: _digest(contents, of_files)}
    for module in modules:
        if module.startswith(("kernels.", "specialise.")):
            known[module] = digest({module})
    for folder in {name.split("/")[0] for name in always}:
        inside = {module for module in modules if f"{module}.".startswith(f"{folder}.")}
        known[f"{folder}.*"] = digest(inside)
    return known


def _module(name, of_folder=False):
    """The module of a file; with `of_folder`, the package that the file lies in."""
    path = name.rpartition("/")[0] if of_folder else name.removesuffix(".py")
    return path.removesuffix("/__init__").replace("/", ".")


def _imports(module, name, content):
    """The names that a module imports, and whether the module may change Numba."""
    import ast

    package = module if name.endswith("/__init__.py") else module.rpartition(".")[0]
    names = set()
    changes_numba = False
    left = ast.parse(content).body
    while left:
        node = left.pop()
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            left += getattr(node, part, ())
        if isinstance(node, ast.Import):
            given = [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")
            above = above[: len(above) - node.level + 1] if node.level else []
            start = ".".join([*above, *filter(None, [node.module])])
            given = [(start, alias.name) for alias in node.names]
        else:
            continue
        for start, last in given:
            if start.split(".")[0] == "numba":
                changes_numba |= (last or start) not in HARMLESS
            names |= {start, f"{start}.{last}"}
    return names, changes_numba


def _known(names, modules):
    """Those of `names` that are modules of these folders, with the packages above them."""
    found = set()
    for name in names:
        parts = name.removeprefix("fastdyn.").split(".")
        found |= {".".join(parts[:i]) for i in range(1, len(parts) + 1)}
    return found & modules.keys()


def _reached(starts, imported):
    """The modules that `starts` import, at any depth, and `starts`."""
    reached = set()
    left = set(starts)
    while left:
        module = left.pop()
        reached.add(module)
        left |= imported[module] - reached
    return reached


def _digest(names, of_files):
    """The hash of files, by their names and the hashes of their contents."""
    lines = "".join(f"{name} {of_files[name]}\n" for name in sorted(names))
    return hashlib.sha256(lines.encode()).hexdigest()


def _files(of_folders):
    """(name, entry) of the sources in folders of fastdyn; `kernels` may lie beside fastdyn."""
    import fastdyn.kernels

    for folder in of_folders:
        path = PACKAGE / folder
        if folder == "kernels":
            path = os.path.dirname(fastdyn.kernels.__file__)
        yield from _sources_in(path, folder)


def _sources_in(folder, name):
    """(name, entry) of the files *.py and *.json in a folder and below it."""
    for entry in os.scandir(folder):
        if entry.name.endswith((".py", ".json")):
            yield f"{name}/{entry.name}", entry
        elif entry.is_dir() and entry.name != "__pycache__":
            yield from _sources_in(entry.path, f"{name}/{entry.name}")
