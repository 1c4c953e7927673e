"""The switching times of one function of a solve, for changing values of its parameters."""

import dis
import math
from typing import Any

import numpy as np

from fastdyn.compile.callables import T, parts_of
from fastdyn.compile.derivatives.sensitivities import slots_of
from fastdyn.compile.sentences import warn
from fastdyn.compile.traced.known import Attempt
from fastdyn.trace.reads.reads import flat
from fastdyn.trace.switching.divisions import MOST_TOLD

from .deciding import Deciding, key_of

KEPT = "switching times"  # keys of a Function's notes
PARTLY = (
    "`%s` decides by the time in ways that take too long to search, as an iteration does that ends "
    "by a tolerance: not all of its switching times are known. If its values jump at such times, "
    "give `breakpoints=` or `max_step=`."
)


class SwitchingWarning(UserWarning):
    """A step jumped over changes of a function, or over two zeros of an event function."""


class Timed:
    """A function whose steps end at its switching times, or are looked at.

    Parameters
    ----------
    place : int
        The index of the function among those of a run.
    bound : Bound
    switches : Switches
    sharp : bool
        Whether the steps are looked at for large changes only.
    """

    def __init__(self, place, bound, switches, sharp):
        self.place = place
        self.bound = bound
        self.switches = switches
        self._sharp = sharp
        begin = 0
        self._groups = []
        fixed = []
        for i, group in enumerate(bound.function.traced.trace.reads.groups):
            end = begin + (1 if group.shape is None else math.prod(group.shape))
            if any(slots.start < end and slots.stop > begin for slots in switches.slots_of_times):
                self._groups.append(i)
            if begin not in switches.differentiated:
                fixed.append(i)
            begin = end
        self._deciding = Deciding(bound, switches, sharp, fixed)

    def times(self, given, y, t0, tf, decides):
        """The Times in a span from the state y; all that may matter, unless it `decides`."""
        if not self.bound.function.address:  # of a function in Python, see `with_trace`
            given = self.bound.given
        found = self._candidates(given, y, t0, tf)
        if not decides:
            return self._deciding.all_of(found)
        return self._deciding.times(found, given, y)

    def _candidates(self, given, y, t0, tf):
        """The Candidates in a span; the last ones of the function are kept."""
        switches = self.switches
        notes = self.bound.function.notes
        key = key_of(given, self._groups)
        if switches.held:
            key += [float(y[i]) for i in switches.held]
        most = MOST_TOLD if self._sharp else None
        place = KEPT, most, switches
        of_values, of_span, grids, found = notes.get(place, (None,) * 4)
        if of_values != key:
            of_span = None
            grids = switches.grids(switches.values(flat(given), y))
        if of_span != (t0, tf):
            values = None if grids else switches.values(flat(given), y)
            found = switches.candidates(values, t0, tf, most=most, grids=grids)
            notes[place] = key, (t0, tf), grids, found
            if found.partly and PARTLY not in notes:
                notes[PARTLY] = True
                warn(PARTLY % getattr(self.bound.held.fun, "__name__", "fun"), SwitchingWarning)
        return found


def with_trace(bound, n):
    """A Bound of a function of n components, which has its trace, if only its code is not ready."""
    account = getattr(bound.callback, "account", None)
    found = account and Attempt(bound.held.fun, bound.held.args, bound.mode, n).late()
    if not found:
        return bound
    late: Any = found[0]
    given = found[1]
    values = list(zip(late.traced.kinds, given, strict=True))
    return bound._replace(function=late, values=values)


def untold(bound, n):
    """Whether a function of the time runs in Python, of n components, that is not traced yet.

    Nobody knows its switching times; true once a function.
    """
    account = getattr(bound.callback, "account", None)
    held = bound.held
    attempt = Attempt(held.fun, held.args, bound.mode, n)
    if account is None or account.untraced or attempt.facts().refusals:
        return False
    account.untraced = True
    parts = parts_of(held.fun, held.args)
    code = parts.function.__code__
    time = code.co_varnames[parts.positional.index(T)]
    return any(time in np.ravel(one.argval) for one in dis.get_instructions(code))


def held_of(bound):
    """The components of the state that the equations do not change."""
    function = bound.function
    if function is None or function.traced is None or function.in_batches or bound.pair:
        return ()
    return function.traced.held if not bound.mode.second_order else ()


def switches_of(bound, held=(), differentiated=()):
    """The Switches of a traced function; None for another one, and for one that never switches.

    `held` are components of the state that do not change, `differentiated` positions of arguments
    by which derivatives are taken.
    """
    function = bound.function
    if function is None or function.traced is None:
        return None
    traced = function.traced
    slots = []
    groups = tuple([bound.at[j - 1] for j in differentiated])
    if groups:
        slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, 0)]
    return function.derived((KEPT, groups, held), lambda: traced.switches_by(slots, held))
