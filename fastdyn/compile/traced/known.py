"""The traces of this process, the reasons of its refusals, and the code that was wrong."""

import functools
from array import array
from typing import Any

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import FIRST
from fastdyn.trace.reads.program import reader

from .. import memory
from ..callables import codes


class Known:
    """A trace for later calls.

    Attributes
    ----------
    traced : Traced
    function : Function
    held : tuple
        The function and the arguments of the trace, kept alive.
    zeros : ndarray
        The slots that were 0 in each comparison of the code.
    """

    def __init__(self, traced, function, held, zeros):
        self.traced = traced
        self.function = function
        self.held = held
        self.zeros = zeros

    @functools.cached_property
    def read(self):
        """``read(fun, args, block=None)``: see `trace.reads.program.reader`."""
        return reader(self.traced.trace.reads, self.zeros, address_of, 8 * FIRST)


class Facts:
    """The traces of a function at a place, and why tracing refused the function.

    Attributes
    ----------
    known : list of Known
    refusals : int
    effect, writes, of_state : bool
        Whether the function was refused because it has a side effect, or writes to arrays, or to
        its state.
    reason, whole : str or None
        The reason and the line of a refusal, for users and for `fastdyn why`.
    late : Function or None
        A trace whose code is not ready yet, as a function without an address.
    """

    def __init__(self):
        self.known: list[Known] = []
        self.refusals = 0
        self.effect = False
        self.writes = False
        self.of_state = False
        self.reason: str | None = None
        self.whole: str | None = None
        self.late: Any = None

    @property
    def acts(self):
        """Whether the function was refused because it does more than give a value."""
        return self.effect or self.writes

    @property
    def refusal(self):
        """The reason and the line of a refusal, for the user or not."""
        return self.reason or self.whole


NOTHING = Facts()
TABLE = memory.Table()  # by `place_of`
_left = memory.Table()  # reasons of functions left to Python, by code and mode
N_LEFT = array("q", [0])  # how often a function was left to Python
N_WRONG = array("q", [0])  # how often because its code gave other values; tests watch the number


def place_of(fun, args, mode, n, varying=(), batches=False):
    """The key of a function: its code objects, mode, lengths and way of tracing."""
    return (*codes(fun, args), mode, n, len(args), tuple(varying), batches)


def facts_of(fun, args, mode, n, varying=(), batches=False):
    """The Facts of a function at the place of `place_of`."""
    return TABLE.get(place_of(fun, args, mode, n, varying, batches)) or NOTHING


def known_trace(fun, args, mode, n, varying=(), batches=False):
    """The Known that holds for a function's current surroundings, and its values; else None.

    `batches` asks for a trace in batches.
    """
    known = facts_of(fun, args, mode, n, varying, batches).known
    for i, one in enumerate(known):
        given = one.read(fun, args)
        if given is not None:
            if i:
                known.insert(0, known.pop(i))
            return one, given
    return None


def late_trace(fun, args, mode, n):
    """The Function without code of a trace that holds now, and its values; None if there is none.

    While the code is made, the function runs in Python.
    """
    for batches in (True, False):
        late = facts_of(fun, args, mode, n, batches=batches).late
        given = None if late is None else reader(late.traced.trace.reads)(fun, args)
        if given is not None:
            return late, given
    return None


def why(fun, args, mode, n, varying=()):
    """The reason and the line of a refusal, if the user should see the reason; else None."""
    reason, wrong = left_of(fun, args, mode)
    return reason if wrong else facts_of(fun, args, mode, n, varying).reason


def may_act(fun, args, mode, n):
    """Whether a function that runs in Python may do more than give a value."""
    facts = facts_of(fun, args, mode, n)
    return facts.acts or not (facts.refusals or left_of(fun, args, mode)[0])


def forget_refusals(fun, args, mode, error):
    """Let a function be traced again that was refused for an exception which Python raised, too.

    The next solve sees what the user has mended.  Messages are not compared: they name stand-ins.
    """
    own = (*codes(fun, args), mode)
    said = f"{type(error).__name__}: "
    for place, entry in list(TABLE.entries.items()):
        facts = entry.value
        if place[: len(own)] == own and (facts.whole or "").startswith(said):
            facts.refusals = 0
            facts.reason = None
            facts.whole = None


def leave(fun, args, mode, reason, wrong):
    """Make a function run in Python from now on, because its code failed or is `wrong`."""
    N_LEFT[0] += 1
    N_WRONG[0] += wrong
    _left.put((codes(fun, args), mode), (reason, wrong))


def left_of(fun, args, mode):
    """The reason why a function was left to Python, and whether its code gave other values."""
    found = _left.get((codes(fun, args), mode)) if _left.entries else None
    return found or (None, False)
