"""The README's Python runs as printed."""

import pathlib
import re

import matplotlib.pyplot as plt

README = pathlib.Path(__file__).parents[1] / "README.md"


def test_the_code_blocks_run(capsys):
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    assert len(blocks) == 5
    scope = {}
    for block in blocks:
        exec(block, scope)
    assert "blows up at t = 0.9999" in capsys.readouterr().out
    plt.close("all")
