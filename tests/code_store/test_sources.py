"""Which sources a key covers: an edit changes the keys of the code that it can change."""

import ast
import pathlib
import shutil

import pytest

import fastdyn
import fastdyn.kernels
from fastdyn import code_store
from fastdyn.code_store import environment
from fastdyn.code_store.environment import FUNCTIONS, KERNELS

PACKAGE = pathlib.Path(fastdyn.__file__).parent
FOLDERS = sorted(
    [path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"]
    + ["kernels"]
)
MAKERS = {"assembled", "compiled", "linked", "without_function"}  # of code_store
COMPILER = {"compile", "trace"}


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the package as it is installed, with the kernels in a folder of the package."""
    package = tmp_path_factory.mktemp("copy") / "fastdyn"
    no_bytecode = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, package, ignore=no_bytecode)
    kernels = pathlib.Path(fastdyn.kernels.__file__).parent
    shutil.copytree(kernels, package / "kernels", ignore=no_bytecode, dirs_exist_ok=True)
    return package


@pytest.fixture
def hashes(copy, monkeypatch):
    """A function that returns the two hashes of the copy, read anew."""
    monkeypatch.setattr(environment, "PACKAGE", copy)
    monkeypatch.setattr(fastdyn.kernels, "__file__", str(copy / "kernels" / "__init__.py"))
    yield lambda: [environment.sources.__wrapped__(made_by) for made_by in (KERNELS, FUNCTIONS)]


@pytest.mark.parametrize("folder", FOLDERS)
def test_an_edit_changes_the_keys_of_what_its_folder_makes(copy, hashes, folder):
    kernels, functions = hashes()
    *_, deepest = sorted((copy / folder).rglob("*.py"), key=lambda path: len(path.parts))
    text = deepest.read_text()
    deepest.write_text(text + "# a comment\n")
    try:
        edited = hashes()
    finally:
        deepest.write_text(text)
    assert (edited[0] == kernels) == (folder not in KERNELS)
    assert (edited[1] == functions) == (folder not in KERNELS | COMPILER)
    assert hashes() == [kernels, functions]


def test_a_new_folder_counts_as_one_that_makes_code():
    assert FUNCTIONS == KERNELS | COMPILER
    assert {"__pycache__", *FUNCTIONS, *environment._WITHOUT} >= set(FOLDERS)


def named(tree):
    """The names of code_store's functions that a module uses."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.ImportFrom) and "code_store" in (node.module or ""):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize("folder", sorted(environment._WITHOUT))
def test_a_folder_outside_the_keys_makes_no_code(folder):
    for path in (PACKAGE / folder).rglob("*.py"):
        used = set(named(ast.parse(path.read_text())))
        assert not used & MAKERS or "code_store" not in path.read_text(), path


def test_only_the_folder_of_kernels_keys_code_by_the_sources_of_kernels():
    """The sources that `build` calls are hashed: kernels are built without the compiler."""
    for path in PACKAGE.rglob("*.py"):
        if path.parts[len(PACKAGE.parts)] not in ("specialise", "code_store"):
            assert "KERNELS" not in set(named(ast.parse(path.read_text()))), path


def test_code_of_functions_and_kernels_has_other_names():
    key = "a key of this test"
    names = {code_store.cache._symbol(key, made_by) for made_by in (KERNELS, FUNCTIONS)}
    assert len(names) == 2
