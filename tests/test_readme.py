"""The Python of the README and of the documentation runs as printed."""

import pathlib
import re

import matplotlib.pyplot as plt
import pytest

ROOT = pathlib.Path(__file__).parents[1]


PAGES = [("README.md", 8), ("docs/long_horizon.md", 2), ("docs/ensembles.md", 4)]


@pytest.mark.parametrize("page, n_blocks", PAGES)
def test_the_code_blocks_run(page, n_blocks, capsys):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert len(blocks) == n_blocks
    scope = {}
    for block in blocks:
        if not block.startswith("# docs: not run"):
            exec(block, scope)
    if page == "README.md":
        assert "blows up at t = 0.9999" in capsys.readouterr().out
    plt.close("all")
