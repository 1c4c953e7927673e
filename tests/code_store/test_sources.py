"""Which sources a key covers: an edit changes the keys of the code that it can change."""

import ast
import json
import os
import pathlib
import shutil
import subprocess
import sys
import types

import pytest

import fastdyn
import fastdyn.kernels
from fastdyn import code_store
from fastdyn.code_store.key import sources as covered
from fastdyn.code_store.key.sources import FUNCTIONS, KERNELS, OF_KERNELS
from fastdyn.kernels.methods import BY_NAME
from fastdyn.specialise import noise, scalar

PACKAGE = pathlib.Path(fastdyn.__file__).parent
OUR_KERNELS = pathlib.Path(fastdyn.kernels.__file__).parent
FOLDERS = sorted(
    {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    | {"kernels"}
)
MAKERS = {"assembled", "compiled", "linked", "without_function"}  # of code_store
COMPILER = {"compile", "trace"}
# What tells Numba something that holds for the whole process, whoever imports the module.
FOR_ALL_CODE = {
    "kernels.algebra.for_numba", "kernels.state.constant", "kernels.vector.number",
    "kernels.vector.scalar_or_vector",
}  # fmt: skip
IMPORTS = (ast.Import, ast.ImportFrom)
RECIPES = scalar.every_kernel()


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the package as it is installed, with the kernels in a folder of the package."""
    package = tmp_path_factory.mktemp("copy") / "fastdyn"
    no_bytecode = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, package, ignore=no_bytecode)
    shutil.copytree(OUR_KERNELS, package / "kernels", ignore=no_bytecode, dirs_exist_ok=True)
    return package


@pytest.fixture
def hashes(copy, monkeypatch):
    """A function that returns the two hashes of the copy, read anew."""
    monkeypatch.setattr(covered, "PACKAGE", copy)
    monkeypatch.setattr(fastdyn.kernels, "__file__", str(copy / "kernels" / "__init__.py"))

    def found():
        covered._hashes.cache_clear()
        return [covered.sources.__wrapped__(made_by) for made_by in (KERNELS, FUNCTIONS)]

    yield found
    covered._hashes.cache_clear()


def edited(path):
    """Other content of a file, with the same meaning."""
    return path.read_bytes() + (b"\n" if path.suffix == ".json" else b"# a comment\n")


def test_an_edit_changes_the_keys_of_what_its_folder_makes(copy, hashes):
    before = hashes()
    for folder in FOLDERS:
        path = copy / folder / "__init__.py"
        if folder == "kernels":
            path = copy / "kernels" / "state" / "record.py"
        elif folder != "fastdyn":
            *_, path = sorted((copy / folder).rglob("*.py"), key=lambda path: len(path.parts))
        content = path.read_bytes()
        path.write_bytes(edited(path))
        after = hashes()
        path.write_bytes(content)
        assert (after[0] == before[0]) == (folder not in OF_KERNELS), folder
        assert (after[1] == before[1]) == (folder not in OF_KERNELS | COMPILER), folder
    assert hashes() == before


def test_a_wheel_brings_the_hashes_of_its_sources(copy, hashes, tmp_path, monkeypatch):
    """A first process does not read the imports of all files, unless a file was edited."""
    nothing = types.SimpleNamespace(entries=lambda name: [], store=lambda *_: None)
    monkeypatch.setattr(covered, "folders", nothing)
    monkeypatch.setattr(covered, "SHIPPED", tmp_path / "sources")
    own = hashes()
    covered.ship(KERNELS, FUNCTIONS)
    read = []
    monkeypatch.setattr(covered, "_computed", lambda contents: read.append(contents) or {"": "x"})
    assert hashes() == own
    assert not read
    path = copy / "trace" / "__init__.py"
    content = path.read_bytes()
    path.write_bytes(edited(path))
    assert hashes()[1] != own[1]
    path.write_bytes(content)
    assert len(read) == 1


@pytest.fixture(scope="module")
def changed():
    """{file of kernels: the keys whose hashes have the content of the file}."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(covered, "_digest", lambda names, of_files: names)
        known = {}
        for folders in (KERNELS.folders, FUNCTIONS.folders):
            places = {name: pathlib.Path(e.path) for name, e in covered._files(folders)}
            contents = {name: path.read_bytes() for name, path in places.items()}
            known[folders] = covered._computed(contents)
    files = {
        key: set().union(*(known[made_by.folders][module] for module in made_by.modules))
        for key, made_by in every_key()
    }
    kernels = [name for name in places if name.startswith("kernels/")]
    return {name: {key for key in files if name in files[key]} for name in kernels}


def every_key():
    """The sources of each kernel, by its key, of functions, and of each method around a function.

    Ensembles in lanes, inlined functions and stages in vectors have these last ones.
    """
    yield from ((key, recipe.made_by) for key, recipe in RECIPES.items())
    yield "a function", FUNCTIONS
    for method in BY_NAME.values():
        module = scalar.module_of(method)
        yield f"a function in {method.name}", FUNCTIONS.around(module)
        yield f"waits {method.name}", KERNELS.around(module)
    yield "a function in noise", FUNCTIONS.around(*noise.MADE_IN)
    yield "noise by address", KERNELS.around(*noise.MADE_IN)


BARE = """
import importlib, json, os, sys, types
for name, path in json.loads(sys.argv[1]).items():  # packages that import nothing by themselves
    package = sys.modules[name] = types.ModuleType(name)
    package.__path__ = [path]
from fastdyn.specialise import dispatchers

def modules():
    kernels = [name for name in sys.modules if name.startswith("fastdyn.kernels")]
    return sorted(name.removeprefix("fastdyn.") for name in kernels)

common = modules()
for calls in json.loads(sys.stdin.read()):
    if os.fork() == 0:
        BY_NAME = dispatchers.BY_NAME
        for call in calls:
            eval(call)
        print(json.dumps(modules()), flush=True)
        os._exit(0)
    if os.wait()[1]:
        raise SystemExit(f"{calls} failed")
"""


def calls():
    """What makes the kernels of each method, and each kernel for all."""
    for name in scalar.FOR_ALL:
        yield name, f"dispatchers.for_all({name!r})"
    for loop, order, width in scalar.SERIES:
        make = "series_in_lanes" if loop == "lanes" else "series"
        yield f"{make} {order} {width}", f"dispatchers.{make}({order}, {width})"
    for name, method in BY_NAME.items():
        method_ = f"BY_NAME[{name!r}]"
        yield scalar._start(name).key, f"dispatchers.start({method_}, False)"
        yield scalar._dense_rows(name).key, f"dispatchers.dense_rows({method_}, False)"
        if method.separable:
            yield scalar._dense_rows(name, True).key, f"dispatchers.dense_rows({method_}, True)"
            yield scalar._shared(name, True).key, f"dispatchers.shared({method_}, True)"
        if not method.series:
            yield scalar._shared(name).key, f"dispatchers.shared({method_}, False)"
        if scalar.inlines(name, 2, None) and not method.series:
            yield f"waits {name}", f"dispatchers.without_function({name!r}, 2)"
        if method.batched:
            yield f"waits {name}", f"dispatchers.stages({name!r}, 2)"
    plan = NOISE.replace("namespace", "types.SimpleNamespace")
    yield "noise by address", f"dispatchers.around_paths('by_address', {plan})"


NOISE = (
    "namespace(method=namespace(step='heun', langevin=False, areas=False), diagonal=True, "
    "ito=False, n_columns=1, n_sources=1, terminal=(True,))"
)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_key_covers_every_module_that_is_imported_to_make_its_kernel(changed):
    """In a process that imports nothing else: nothing that a kernel is made from is left out."""
    made_by, groups = dict(every_key()), {}
    for key, call in calls():
        groups.setdefault(made_by[key], []).append((key, call))
    bare = {"fastdyn": str(PACKAGE), "fastdyn.specialise": str(PACKAGE / "specialise")}
    given = [[call for _, call in group] for group in groups.values()]
    done = subprocess.run(
        [sys.executable, "-c", BARE, json.dumps(bare)], input=json.dumps(given),
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert {key for group in groups.values() for key, _ in group} >= RECIPES.keys()
    files = {covered._module(name): name for name in changed if name.endswith(".py")}
    for group, line in zip(groups.values(), done.stdout.splitlines(), strict=True):
        imported = json.loads(line)
        assert "kernels.calls.user_function" in imported
        for key, _ in group:
            missing = [module for module in imported if key not in changed[files[module]]]
            assert not missing, (key, missing)


OUTSIDE = {  # an edit of a file of kernels that changes no key of a family
    "advance RK45": "methods/radau/step.py", "start stepping.first_step.hairer": "methods/rk45.py",
    "dense rows rk45.RK45": "methods/dop853.py", "advance Radau": "methods/bdf/step.py",
    "advance LSODA": "methods/rodas5p/step.py", "advance VelocityVerlet": "methods/explicit.py",
    "split Yoshida4": "methods/gauss/methods.py", "advance Gauss4": "methods/symplectic.py",
    "advance BDF of residuals": "methods/bdf/step.py", "watch": "stepping/adaptive.py",
    "series 20 4": "methods/rk45.py", "series_in_lanes 20 4": "methods/rk45.py",
    "newton": "stepping/backward.py", "sweep": "stepping/collocation.py",
    "factors": "output/events.py", "wisdom holman": "output/events.py",
    "other factors": "methods/radau/step.py", "pencil rates": "output/events.py",
    "waits Tsit5": "methods/taylor/steps.py", "a function": "methods/radau/step.py",
    "a function in RK45": "methods/radau/step.py", "a function in noise": "methods/rk45.py",
    "noise by address": "methods/explicit.py",
}  # fmt: skip


@pytest.mark.parametrize("key", OUTSIDE)
def test_an_edit_outside_the_imports_of_a_kernel_changes_no_key_of_it(changed, key):
    assert key not in changed[f"kernels/{OUTSIDE[key]}"]


def test_an_edit_of_a_method_changes_its_keys(changed):
    for name, method in BY_NAME.items():
        file = f"kernels/methods/{method.file.replace('.', '/')}.py"
        keys = {scalar._shared(name).key} if not method.series else set()
        if method.separable:
            keys |= {scalar._shared(name, True).key, scalar._dense_rows(name, True).key}
        keys |= {f"waits {name}", f"a function in {name}"}
        assert keys <= changed[file], name


@pytest.mark.parametrize("file", ["noise/steps.py", "noise/passages.py", "random/philox.py"])
def test_an_edit_of_the_loop_over_paths_changes_its_keys_alone(changed, file):
    assert changed[f"kernels/{file}"] == {"a function in noise", "noise by address"}


def test_what_numba_is_told_for_the_process_counts_for_all_code(changed):
    every = {key for key, _ in every_key()}
    found = {covered._module(name) for name in changed if changed[name] == every}
    assert FOR_ALL_CODE <= found
    assert any("methods/facts.json" in name and changed[name] for name in changed)
    assert changed["kernels/methods/facts.json"] >= {"advance RK45", "a function in RK45"}


def test_kernels_read_no_other_files_and_import_by_statements():
    """Imports by strings, and tables of numbers elsewhere, would be no part of a key."""
    by_strings = []
    for path in OUR_KERNELS.rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            assert path.suffix == ".py" or (path.parent / "__init__.py").exists()
            assert path.suffix in (".py", ".json"), path
            by_strings += [path.stem] * any(
                word in path.read_text() for word in ("import_module", "__import__")
            )
    assert by_strings == ["method"]  # of a method, whose module is named by `scalar.module_of`


def test_a_function_that_calls_a_kernel_depends_on_the_module_of_the_kernel():
    from fastdyn.compile.fingerprint import frozen, frozen_function, kernels_in
    from fastdyn.kernels.output.brent import resolution

    def root(t, y):
        return resolution(t) - y[0]

    assert kernels_in(frozen_function(root)) == {"kernels.output.brent"}
    assert kernels_in((("y",), frozen(resolution))) == {"kernels.output.brent"}
    assert kernels_in(frozen_function(lambda t, y: abs(y))) == set()


def test_a_new_folder_counts_as_one_that_makes_code():
    assert FUNCTIONS.folders == OF_KERNELS | COMPILER
    assert {"__pycache__", *FUNCTIONS.folders, *covered._WITHOUT} >= set(FOLDERS)


def named(tree):
    """The names of code_store's functions that a module uses."""
    imported, places = set(), {"code_store"}  # `places`: modules and classes of code_store
    nodes = list(ast.walk(tree))
    for node in nodes:
        for alias in getattr(node, "names", ()) if isinstance(node, IMPORTS) else ():
            whole = f"{getattr(node, 'module', None)}.{alias.name}"
            if "code_store" in whole.split("."):
                imported.add(alias.name)
                places.add(alias.asname or alias.name)
    yield from imported
    for node in nodes:
        if isinstance(node, ast.Attribute):
            of = node.value
            if getattr(of, "id", getattr(of, "attr", None)) in places:
                yield node.attr


@pytest.mark.parametrize("folder", sorted(covered._WITHOUT))
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
