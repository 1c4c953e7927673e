"""Runs code in a process in which modules have another text: a record more in a table."""

import subprocess
import sys

BEGIN = """
import importlib.machinery, sys

EDITS = {edits!r}


class Edited(importlib.machinery.SourceFileLoader):
    def path_stats(self, path):
        raise OSError("the bytecode on disk has the text before")

    def source_to_code(self, data, path, *, _optimize=-1):
        text, edits = data.decode(), EDITS[self.name]
        for old, new in zip(edits[::2], edits[1::2], strict=True):
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        return super().source_to_code(text, path, _optimize=_optimize)


class Finder(importlib.machinery.PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name not in EDITS:
            return None
        spec = super().find_spec(name, path, target)
        spec.loader = Edited(name, spec.origin)
        return spec


sys.meta_path.insert(0, Finder)
"""


def run_edited(code, edits):
    """Run code where each module of `edits`, {name: (old, new, ...)}, has new for old text."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", BEGIN.replace("{edits!r}", repr(edits)) + code],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
