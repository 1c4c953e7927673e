"""The notebooks are stored without outputs, are valid, and use what is public."""

import ast
import importlib
import json
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
TOPICS = ("analysis", "dae", "derive", "drift", "ensemble", "matlab", "solve")
DOORS = ("fastdyn.jax", "fastdyn.pytensor", "fastdyn.torch")  # their libraries may be missing
STORED = ("pymc", "torch")
PUBLIC = ("fastdyn", *(f"fastdyn.{topic}" for topic in TOPICS), "fastdyn.systems", *DOORS)
EACH = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def cells(path, kind):
    found = json.loads(path.read_text("utf-8"))["cells"]
    return [cell for cell in found if cell["cell_type"] == kind]


def sources(path, kind):
    return ["".join(cell["source"]) for cell in cells(path, kind)]


def public_names(module):
    if module in DOORS:
        return {"Solution", "solve_ivp"}
    loaded = importlib.import_module(module)
    return {*loaded.__all__, *getattr(loaded, "SYSTEMS", ())}


def not_public(text):
    """Names of fastdyn that code imports, or asks its modules for, and that are not public."""
    tree, found, modules = ast.parse(text), [], {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "fastdyn":
                    modules[alias.asname or "fastdyn"] = alias.name if alias.asname else "fastdyn"
                    found += [] if alias.name in PUBLIC else [alias.name]
        elif isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == "fastdyn":
            names = [alias.name for alias in node.names]
            known = public_names(node.module) if node.module in PUBLIC else ()
            found += [f"{node.module}.{name}" for name in names if name not in known]
            for alias in node.names:
                if f"{node.module}.{alias.name}" in PUBLIC:
                    modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    for node in ast.walk(tree):
        if not isinstance(node, ast.Attribute):
            continue
        of = modules.get(node.value.id) if isinstance(node.value, ast.Name) else None
        if node.attr.startswith("_") or (of and node.attr not in public_names(of)):
            found.append(f"{of or '...'}.{node.attr}")
    return found


def test_they_are_numbered():
    assert sorted(int(path.name.split("_")[0]) for path in NOTEBOOKS) == [*range(1, 12)]


@EACH
def test_nothing_but_sources_is_stored(path):
    """Or all outputs, where the documentation is not built with the library that is needed."""
    whole = json.loads(path.read_text("utf-8"))
    stored = whole["metadata"].get("fastdyn", {}).get("needs") in STORED
    assert cells(path, "code")
    for cell in cells(path, "code"):
        assert (cell["execution_count"] is not None) == stored
        assert stored or cell["outputs"] == []
    assert any(cell["outputs"] for cell in cells(path, "code")) == stored
    assert (whole["nbformat"], whole["nbformat_minor"]) == (4, 5)
    assert whole["metadata"]["kernelspec"]["name"] == "python3"
    assert "attachments" not in path.read_text("utf-8")


@EACH
def test_it_is_valid(path):
    nbformat = pytest.importorskip("nbformat")
    nbformat.validate(nbformat.read(path, nbformat.NO_CONVERT))


@EACH
def test_it_names_what_is_public(path):
    assert not_public("\n".join(sources(path, "code"))) == []


@pytest.mark.parametrize(
    "text",
    [
        "from fastdyn.run.loop import counters",
        "from fastdyn import plot",
        "import fastdyn\nfastdyn.run",
        "from fastdyn import systems\nsystems.sputnik()",
        "result._asked",
        "import fastdyn.kernels",
    ],
)
def test_what_is_private_is_found(text):
    assert not_public(text)


@EACH
def test_it_is_a_lecture(path):
    text = "\n\n".join(sources(path, "markdown"))
    for part in (r"^# \S", r"^\*\*The question\.\*\*", r"^\*\*The models?\.\*\*", r"\$\$"):
        assert re.search(part, text, re.MULTILINE), part
    exercises = text.partition("## Exercises")[2]
    assert 3 <= len(re.findall(r"^\d\. ", exercises, re.MULTILINE)) <= 5
