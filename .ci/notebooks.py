"""The notebooks whose libraries are installed here, one a line; the others are shown as stored.

A notebook names the library that it needs in its metadata: {"fastdyn": {"needs": "torch"}}.
"""

import importlib.util
import json
import pathlib

FOLDER = pathlib.Path(__file__).parents[1] / "notebooks"


def needed(path):
    """The library that a notebook needs, or None."""
    return json.loads(path.read_text("utf-8"))["metadata"].get("fastdyn", {}).get("needs")


def runnable(path):
    """Whether the library that a notebook needs is installed."""
    name = needed(path)
    return name is None or importlib.util.find_spec(name) is not None


if __name__ == "__main__":
    print(*[path.as_posix() for path in sorted(FOLDER.glob("*.ipynb")) if runnable(path)], sep="\n")
