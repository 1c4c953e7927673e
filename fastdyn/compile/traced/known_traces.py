"""Remembers traces of functions, and the reasons why functions were refused."""

import functools
import types as python
from array import array

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import FIRST
from fastdyn.trace.reads.program import reader

from .. import memory
from ..callables.jitted import is_jitted
from ..callables.parts import codes_of


class Known:
    """A trace for later calls.

    Attributes
    ----------
    traced : Traced or TracedInBatches
    function : Function
    held : tuple
        The function and the arguments of the trace, kept alive.
    zeros : ndarray
        The slots that were 0 in each comparison of the code.
    """

    def __init__(self, traced, function, held, zeros):
        self.traced, self.function, self.held, self.zeros = traced, function, held, zeros

    @functools.cached_property
    def read(self):
        """``read(fun, args, block=None)``: see `trace.reads.program.reader`."""
        return reader(self.traced.trace.reads, self.zeros, address_of, 8 * FIRST)


class Traces:
    """The traces of a code object, and the reasons why tracing refused the code object."""

    def __init__(self):
        self.known: list[Known] = []
        self.refusals, self.effect, self.writes = 0, False, False
        self.of_state = False  # whether the function writes to its state
        self.reason: str | None = None  # for users
        self.whole: str | None = None  # for `fastdyn why`


NOTHING = Traces()
TABLE = memory.Table()  # by `place_of`
_left = memory.Table()  # reasons of functions left to Python, by code and mode
N_LEFT = array("q", [0])  # how often a function was left to Python
N_WRONG = array("q", [0])  # how often because its code gave other values; tests watch the number


def known_trace(fun, args, mode, n, varying=(), batches=False):
    """The Known that holds for a function's current surroundings, and its values; else None.

    `batches` asks for a trace in batches.
    """
    known = _traces_at(fun, args, mode, n, varying, batches).known
    for i, one in enumerate(known):
        given = one.read(fun, args)
        if given is not None:
            if i:
                known.insert(0, known.pop(i))
            return one, given
    return None


def why(fun, args, mode, n, varying=()):
    """The reason and the line of a refusal, if the user should see the reason; else None."""
    reason, wrong = _left_of(fun, args, mode)
    return reason if wrong else _traces_at(fun, args, mode, n, varying).reason


def _traces_at(*place):
    return TABLE.get(place_of(*place)) or NOTHING


def refusal(fun, args, mode, n, batches=False):
    """The reason and the line of a refusal by tracing, for the user or not; else None."""
    traces = _traces_at(fun, args, mode, n, (), batches)
    return traces.reason or traces.whole


def has_effect(fun, args, mode, n, varying=()):
    """Whether a function was refused because of a side effect."""
    return _traces_at(fun, args, mode, n, varying).effect


def acts(fun, args, mode, n, varying=()):
    """Whether a function was refused because it has a side effect, or writes to arrays."""
    traces = _traces_at(fun, args, mode, n, varying)
    return traces.effect or traces.writes


def may_have_effect(fun, args, mode, n):
    """Whether a function that runs in Python may have a side effect."""
    traces = _traces_at(fun, args, mode, n)
    known = traces.refusals or left_to_python(fun, args, mode)
    return not known or traces.effect or traces.writes


def forget_refusals(fun, args, mode, error):
    """Let a function be traced again that was refused for an exception which Python raised, too.

    The next solve sees what the user has mended.  Messages are not compared: they name stand-ins.
    """
    own, said = (*codes(fun, args), mode), f"{type(error).__name__}: "
    for place, entry in list(TABLE.entries.items()):
        traces = entry.value
        if place[: len(own)] == own and (traces.whole or "").startswith(said):
            traces.refusals, traces.reason, traces.whole = 0, None, None


def writes_to_state(fun, args, mode, n):
    """Whether a function was refused because it writes to its state."""
    return _traces_at(fun, args, mode, n).of_state


def leave_to_python(fun, args, mode, reason, wrong):
    """Make a function run in Python from now on, because its code failed or is `wrong`."""
    N_LEFT[0] += 1
    N_WRONG[0] += wrong
    _left.put((codes(fun, args), mode), (reason, wrong))


def left_to_python(fun, args, mode):
    """The reason why a function was left to Python; None if the function was not."""
    return _left_of(fun, args, mode)[0]


def is_wrong(fun, args, mode):
    """Whether the machine code of a function gave other values than the function."""
    return _left_of(fun, args, mode)[1]


def _left_of(fun, args, mode):
    found = _left.get((codes(fun, args), mode)) if _left.entries else None
    return found or (None, False)


def place_of(fun, args, mode, n, varying=(), batches=False):
    """The key of a function: its code objects, mode, lengths and way of tracing."""
    return (*codes(fun, args), mode, n, len(args), tuple(varying), batches)


def in_batches(function):
    """Whether a compiled function works on long arrays."""
    return function.traced is not None and function.traced.in_batches


def codes(fun, args):
    """The identities of the code of a callable and of the callables among its arguments."""
    return (code_of(fun), *[code_of(a) for a in args if callable(a)])


def code_of(fun):
    """The identity of a callable's code."""
    while isinstance(fun, functools.partial):
        fun = fun.func
    if isinstance(fun, python.MethodType):
        fun = fun.__func__
    fun = fun.py_func if is_jitted(fun) else fun
    if isinstance(fun, python.FunctionType):
        return codes_of(fun)
    return (type(fun),)
