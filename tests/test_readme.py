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


PAGES = ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("**/*.md"))]
WITH_CODE = [page for page in PAGES if blocks(page)]


@pytest.mark.parametrize("page", WITH_CODE)
def test_the_code_blocks_run(page):
    scope = {}
    for block in blocks(page):
        exec(block, scope)
    plt.close("all")


def test_the_pages_are_found():
    expected = {"README.md", "docs/ensembles.md", "docs/long_horizon.md", "docs/methods.md"}
    assert expected <= set(WITH_CODE)


def test_the_links_of_the_readme_lead_somewhere():
    links = re.findall(r"\]\(([^)#]+)", (ROOT / "README.md").read_text("utf-8"))
    assert [link for link in links if not (ROOT / link).exists()] == []
