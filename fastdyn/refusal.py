"""Why a function cannot be compiled, in one sentence, said once."""

import warnings


class CompileWarning(UserWarning):
    """A function could not be compiled and runs in Python."""


class Uncompilable(Exception):
    """Why a function cannot be compiled."""


_warned: set = set()


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


def warn_once(fun, mode, reason):
    name = getattr(fun, "__qualname__", None) or repr(fun)
    identity = (getattr(fun, "__code__", type(fun)), mode)
    if identity in _warned:
        return
    _warned.add(identity)
    warnings.warn(
        f"{name} cannot be compiled and runs in Python, many times slower: {reason}",
        CompileWarning,
        stacklevel=5,
    )
