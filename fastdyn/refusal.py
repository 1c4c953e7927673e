"""Why a function cannot be compiled, in one sentence, said once."""

import sys
import warnings


class CompileWarning(UserWarning):
    """A function could not be compiled and runs in Python."""


class Uncompilable(Exception):
    """Why a function cannot be compiled."""


class GaveUp(Exception):
    """A compiled function raised where the Python function gives a value."""

    def __init__(self, bound, t):
        super().__init__(f"its compiled form could not go on at t = {t:.10g}")
        self.bound = bound


_warned: set = set()
PACKAGE = f"{__package__}."


def explain(error):
    """One sentence from Numba's report: what it could not compile, and the line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    skip = ("Failed in", "During:", "File ", "<source", "- Resolution", "There are", "[", "raised")
    what = [s for s in lines if not s.startswith(skip) and "type inference" not in s]
    at = [s for s in lines if s.startswith('File "')]
    sentence = what[0].rstrip(".:") if what else type(error).__name__
    if at:
        file, _, line = at[0].partition(", line ")
        sentence += f" ({file[6:].rstrip(chr(34))}, line {line.split(':')[0].strip()})"
    return sentence


def warn_once(fun, reason):
    """Say that a function runs in Python, at the line of the user who called."""
    name = getattr(fun, "__qualname__", None) or repr(fun)
    identity = getattr(fun, "__code__", type(fun))
    if identity in _warned:
        return
    _warned.add(identity)
    warnings.warn(
        f"{name} cannot be compiled and runs in Python, many times slower: {reason}",
        CompileWarning,
        stacklevel=_levels_inside(),
    )


def _levels_inside():
    """Frames from the caller of `warn_once`'s warning to the first one outside this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(PACKAGE):
        frame, level = frame.f_back, level + 1
    return level
