"""The Python of the README and of every page of the documentation runs as printed."""

import pathlib
import re

import matplotlib.pyplot as plt
import pytest

ROOT = pathlib.Path(__file__).parents[1]


def blocks(page):
    """The Python of a page, block by block, but for what says that it is not run."""
    found = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text("utf-8"), re.DOTALL)
    return [block for block in found if not block.startswith("# docs: not run")]


@pytest.mark.hunt
def test_the_blocks_of_other_libraries_run():
    """They are marked `py`."""
    pytest.importorskip("heyoka")
    pytest.importorskip("diffrax")
    text, scope = (ROOT / "docs/six_tasks.md").read_text("utf-8"), {}
    for block in re.findall(r"```py\n(.*?)```", text, re.DOTALL):
        exec(block, scope)


PAGES = ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("**/*.md"))]
NOT_THERE = {"kernels/methods/NAME.py"}  # of a recipe
WITH_CODE = [page for page in PAGES if blocks(page)]


OF_DOCS = [pytest.param(page, marks=pytest.mark.hunt) for page in WITH_CODE[1:]]


@pytest.mark.parametrize("page", [WITH_CODE[0], *OF_DOCS])  # the README, and hunts
def test_the_code_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some write files
    scope = {}
    for block in blocks(page):
        needed = re.match(r"# docs: needs (\w+)", block)
        if needed:
            pytest.importorskip(needed[1])
        exec(block, scope)
    plt.close("all")


def test_the_first_result_is_the_one_that_is_printed(capsys):
    block = blocks("README.md")[0]
    exec(block, {})
    assert f"# {capsys.readouterr().out}" == re.search(r"# [^#]*$", block)[0]


def test_the_pages_are_found():
    expected = {"README.md", "docs/ensembles.md", "docs/long_horizon.md", "docs/methods.md"}
    assert expected <= set(WITH_CODE)


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md"])
def test_the_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)", (ROOT / page).read_text("utf-8"))
    assert links and [link for link in links if not (ROOT / link).exists()] == []


def test_the_places_that_the_guide_names_exist():
    text = (ROOT / "docs/developing.md").read_text("utf-8")
    named = set(re.findall(r"(?:fastdyn|kernels|tests|docs|bench)/[\w/.]*\w", text)) - NOT_THERE
    assert len(named) > 30 and [place for place in named if not (ROOT / place).exists()] == []
    files = [ROOT / place for place in named if place.endswith(".py")]
    source = "\n".join(file.read_text("utf-8") for file in files)
    constants = set(re.findall(r"`([A-Z][A-Z_]+)`", text)) - {"NUMBA_CACHE_DIR"}
    assert constants and [name for name in constants if f"\n{name}" not in source] == []
