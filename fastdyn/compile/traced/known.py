"""The traces of this process, the reasons of its refusals, and the code that was wrong."""

import functools
from array import array
from typing import Any, NamedTuple

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


class TracesOfPlace:
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


NOTHING = TracesOfPlace()
TABLE = memory.Table()  # by the places of Attempts
_left = memory.Table()  # reasons of functions left to Python, by code and mode
N_LEFT = array("q", [0])  # how often a function was left to Python
N_WRONG = array("q", [0])  # how often because its code gave other values; tests watch the number


class Left(NamedTuple):
    """Why a function was left to Python; `wrong`: because its code gave other values."""

    reason: str | None = None
    wrong: bool = False


NOT_LEFT = Left()


class Attempt:
    """The attempt to make code of a function for a y of n numbers; what earlier attempts found.

    `varying` has the positions, from 1, of the arguments that vary between calls.
    """

    def __init__(self, fun, args, mode, n, varying=()):
        self.fun = fun
        self.args = args
        self.mode = mode
        self.n = n
        self.varying = tuple(varying)

    @functools.cached_property
    def codes(self):
        """The identities of the code of the function and of those among its arguments."""
        return codes(self.fun, self.args)

    def place(self, batches=False):
        """The key of the function in TABLE; `batches` asks for a trace in batches."""
        return (*self.codes, self.mode, self.n, len(self.args), self.varying, batches)

    def facts(self, batches=False):
        """The TracesOfPlace of the function."""
        return TABLE.get(self.place(batches)) or NOTHING

    def known(self, batches=False):
        """The Known that holds for the current surroundings, and its values; else None."""
        known = self.facts(batches).known
        for i, one in enumerate(known):
            given = one.read(self.fun, self.args)
            if given is not None:
                if i:
                    known.insert(0, known.pop(i))
                return one, given
        return None

    def late(self):
        """The Function without code of a trace that holds now, and its values; None without one.

        While the code is made, the function runs in Python.
        """
        for batches in (True, False):
            late = self.facts(batches).late
            given = None if late is None else reader(late.traced.trace.reads)(self.fun, self.args)
            if given is not None:
                return late, given
        return None

    @property
    def left(self):
        """The Left of the function: without a reason, the function may have code."""
        found = _left.get((self.codes, self.mode)) if _left.entries else None
        return found or NOT_LEFT

    def leave(self, reason, wrong):
        """Make the function run in Python from now on: its code failed or is `wrong`."""
        N_LEFT[0] += 1
        N_WRONG[0] += wrong
        _left.put((self.codes, self.mode), Left(reason, wrong))

    def why(self):
        """The reason and the line of a refusal, if the user should see the reason; else None."""
        left = self.left
        return left.reason if left.wrong else self.facts().reason

    def may_act(self):
        """Whether the function, which runs in Python, may do more than give a value."""
        facts = self.facts()
        return facts.acts or not (facts.refusals or self.left.reason)

    def forget_refusals(self, error=None):
        """Let the function be traced again that was refused for an exception which Python raised.

        Without an exception for any reason, of which the caller raises one: no refusal that ends a
        call is remembered.  The next solve sees what the user has mended.  Messages are not
        compared: they name stand-ins.
        """
        own = (*self.codes, self.mode)
        said = "" if error is None else f"{type(error).__name__}: "
        for place, entry in list(TABLE.entries.items()):
            facts = entry.value
            if place[: len(own)] == own and (facts.whole or "").startswith(said):
                facts.refusals = 0
                facts.reason = None
                facts.whole = None
