"""Events at breakpoints, where their functions may jump over zero."""

from ...calls.block import MASS
from ...calls.consistent import made_consistent
from ...calls.user_function import evaluate
from ...jit.options import INTERNAL, njit
from ...state.record import Y
from ...state.rows import copy_row
from ..brent import takes_edges
from ..events import FAILED


@njit(**INTERNAL)
def note_border(solve, output, events, scratch, meets, end):
    """Note the events whose functions cross zero at the breakpoint at which a step ends.

    The functions may jump there, also to zero or from zero: g_new becomes the value behind.
    Notes that cannot be told from the breakpoint are at the breakpoint.  Returns the new end of the
    notes, or FAILED.
    """
    o = output.record[0]
    t = output.segments[o.i_segment, 2]
    behind = output.segments[o.i_segment + 1, 0]
    y = scratch[0]
    copy_row(solve.work[Y], y)
    if solve.block[MASS] != 0 and not made_consistent(solve.block[MASS], behind, y):
        return FAILED
    noted = end
    for k in range(o.n_events, noted):
        if abs(events.t[k] - t) <= max(meets, abs(behind - t)):
            events.t[k] = t
    for i in range(len(events.table)):
        e = events.table[i]
        if not evaluate(e.block, behind, y, scratch[1]):
            return FAILED
        before = e.g_new
        after = scratch[1, 0]
        change = after - before
        crosses = before < 0.0 < after or before > 0.0 > after
        if takes_edges(e):
            crosses = crosses or (before * after == 0.0 and before != after)
        crosses = crosses and change * e.direction >= 0.0
        for k in range(o.n_events, noted):
            crosses = crosses and not (events.index[k] == i and events.t[k] == t)
        if crosses:
            e.size = max(e.size, abs(change))
            events.index[end] = i
            events.t[end] = t
            end += 1
        e.g_new = after
    return end
