"""A warning of pulses in time that fall between two steps of constant length."""

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.run.functions.switching import SwitchingWarning, place_told
from fastdyn.run.functions.timed import Timed, switches_of, with_trace

TOLD = "told of a lost pulse"  # a key of a Function's notes


def warn_of_pulses(bounds, grid, y0, method):
    """Warn, once a function and method, if the function changes twice within a step.

    The steps look at their starts; what begins and ends behind a start is lost.
    """
    for i, each in enumerate(bounds.all):
        bound = with_trace(each, each.n)
        switches = switches_of(bound)
        if switches is None:
            continue
        place = place_told(bound, method, TOLD)
        if place in bound.function.notes:
            continue
        found = Timed(i, bound, switches, True).times(
            bound.given, y0[: bound.n], grid.t0, grid.tf, True
        )
        times = np.sort(found.t[found.sharp])
        step = np.ceil((times - grid.t0) / grid.h)  # a start at a change looks behind the change
        lost = np.flatnonzero(np.diff(step) == 0)
        if len(lost):
            bound.function.notes[place] = True
            a, b = times[lost[0] : lost[0] + 2].tolist()
            warn(
                f"`{getattr(bound.held.fun, '__name__', 'a function')}` changes at t = {a:.10g} "
                f"and t = {b:.10g}, and no step of {method.name} begins between: what happens "
                f"between is lost. Give `step={b - a:.2g}`.",
                SwitchingWarning
            )  # fmt: skip
