"""The reasons why a function cannot be compiled, as sentences, and the warnings that print them."""

import contextlib
import contextvars
import linecache
import os
import re
import sys
import warnings
from types import BuiltinFunctionType, FunctionType
from typing import Any

from fastdyn.code_store import Unsealable
from fastdyn.words.user_lines import of_user

from . import memory
from .callables import SWITCHED_OFF, Uncompilable, code_of, plain_function


class CompileWarning(UserWarning):
    """A function could not be compiled and runs in Python."""


class FoundLater(Uncompilable):
    """The reason why a function cannot be compiled, found when its compiled form ran."""


class GaveUp(Exception):
    """Raised if compiled code fails where the Python function gives a value.

    `wrong` code gives another value than the function: then no tier may use the code.
    """

    wrong = False

    def __init__(self, bound, t):
        super().__init__(f"its compiled form could not go on at t = {t:.10g}")
        self.bound = bound


class WritesToState(ValueError):
    """Raised if a function writes to its state in a solve that cannot treat writes as SciPy does.

    `begun` tells whether functions have been called before.
    """

    def __init__(self, begun=False):
        self.begun = begun
        super().__init__(
            "`fun` writes to the state that it is given, which changes the state at the end of "
            "each step; with events, `t_eval` or `dense_output` only solve_ivp does that."
        )


_warned = memory.Table()  # functions for which the user has got a warning
NAMED = FunctionType | BuiltinFunctionType | type
PACKAGE = f"{__name__.partition('.')[0]}."


# Numba's message -> its meaning for the user; \1 and \2 are the groups of the pattern.
SENTENCES = (
    (r"Untyped global name '([\w.]+)'.*", r"`\1` has no compiled form"),
    (r"NameError: name '([\w.]+)' is not defined", r"`\1` has no compiled form"),
    (
        r"No implementation of function Function\(<built-in function setitem>\) found.*",
        "it writes to an item of something that only Python can change",
    ),
    (
        r"No implementation of function Function\(<(?:class|function|ufunc|built-in function) "
        r"'?(?!\w*_impl)([\w.]+)[^>]*>\) found.*",
        r"`\1` has no compiled form for what it is given",
    ),
    (r"it calls _numba_hash\w+", "it looks up text in a set or a dict"),
    (r"it calls _?(?:numba|Py|NRT)\w+", "it goes back to Python"),
)
INSIDE = r"0x[0-9a-f]{6}| object at |\bfastdyn\b|(?i:numba)|\$"  # parts without meaning to the user
AT = re.compile(r"^File \"(.+)\", line (\d+)")
ANY = "it does what only Python can do"


def explain(error):
    """One sentence: the construct that Numba could not compile, and the user's line."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(error))  # terminal colours
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if isinstance(error, Uncompilable):  # behind the names of Numba's steps
        return lines[-1]
    skip = ("Failed in", "During:", "File ", "<source", "- Resolution", "There are", "[", "raised")
    what = [s for s in lines if not s.startswith(skip) and "type inference" not in s]
    sentence = (what or [""])[0].rstrip(".:")
    known = isinstance(error, Unsealable)
    for pattern, meaning in SENTENCES:
        sentence, count = re.subn(pattern, meaning, sentence)
        known = known or count > 0
    places = [(at[1], int(at[2])) for at in map(AT.match, lines) if at]
    place = next(((_whole(file), line) for file, line in places if of_user(file)), None)
    if not known or re.search(INSIDE, sentence):
        source = linecache.getline(*place).strip() if place else ""
        source = re.sub(r"\s+#.*", "", source)
        sentence = f"`{source}` has no compiled form" if source else ANY
    return located(sentence, place)


def _whole(file):
    """The absolute path of a file that Numba names relative to the working directory."""
    return os.path.abspath(file) if os.path.exists(file) else file


def located(sentence, place):
    """Append (file, line) to a sentence, if known."""
    return f"{sentence} ({place[0]}, line {place[1]})" if place else sentence


def name_of(fun):
    """The name of a function in a sentence."""
    plain = plain_function(fun)
    return plain.__qualname__ if isinstance(plain, NAMED) else type(fun).__name__


def _code_of_user(function):
    """The code of a function, or of the user's `fun` that a form of fastdyn's calls; or None."""
    code = function.__code__ if isinstance(function, FunctionType) else None
    if code is None or of_user(code.co_filename) or "fun" not in code.co_freevars:
        return code
    cells: Any = function.__closure__
    return _code_of_user(plain_function(cells[code.co_freevars.index("fun")].cell_contents))


def warn_once(fun, reason):
    """Warn once for each function, at the user's line, that the function runs in Python."""
    plain = plain_function(fun)
    if reason != SWITCHED_OFF and not re.search(r", line \d+\)$", reason):
        code = _code_of_user(plain)
        if code is not None and not of_user(code.co_filename):
            code = None
        reason = located(reason, code and (code.co_filename, code.co_firstlineno))
    name = name_of(fun)
    identity = reason if reason == SWITCHED_OFF else (type(fun), code_of(plain), name)
    if _warned.get(identity):
        return
    _warned.put(identity, True)
    warn(
        f"{name} cannot be compiled and runs in Python, many times slower: {reason}", CompileWarning
    )


_told: contextvars.ContextVar[set | None] = contextvars.ContextVar("told", default=None)


@contextlib.contextmanager
def told_once():
    """Within this context, `warn` gives each sentence once: one problem is solved several times."""
    token = _told.set(set())
    try:
        yield
    finally:
        _told.reset(token)


def warn(said, category: type[Warning] = UserWarning):
    """Give a warning at the first line outside fastdyn."""
    told = _told.get()
    if told is not None:
        if said in told:
            return
        told.add(said)
    warnings.warn(said, category, stacklevel=_levels_inside())


def _levels_inside():
    """The `stacklevel` at which the caller's warning names the first line outside fastdyn."""
    frame = sys._getframe(1)
    level = 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(PACKAGE):
        frame = frame.f_back
        level = level + 1
    return level
