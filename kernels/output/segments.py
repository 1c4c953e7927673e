"""The segments of a span with breakpoints: the end of a segment, the start of the next."""

from ..calls.block import MASS
from ..calls.consistent import made_consistent
from ..jit.options import INTERNAL, njit
from ..state.record import RAISED, K, Y
from ..state.rows import slot
from .projection import derive


@njit(**INTERNAL)
def end_of_span(s, segments):
    """The time at which the last step ends."""
    return segments[len(segments) - 1, 1] if len(segments) > 0 else s.t_end


@njit(**INTERNAL)
def ends_segment(s, o, segments):
    """True if the steps run to the end of the segment, False if a scheduled time is earlier."""
    return len(segments) == 0 or s.t_end == segments[o.i_segment, 1]


@njit(**INTERNAL)
def time_reached(s, o, segments, over):
    """The time that the output stores for the end of a step."""
    if over:
        return segments[o.i_segment, 2] if ends_segment(s, o, segments) else s.t_end
    t_end = end_of_span(s, segments)
    return t_end if s.direction * (s.t - t_end) > 0.0 else s.t


@njit(**INTERNAL)
def is_border(s, o, segments):
    """True if the last step ends at a breakpoint, before which and behind which t differs."""
    return o.i_segment + 1 < len(segments) and s.t == segments[o.i_segment, 1]


@njit(**INTERNAL)
def _extrapolate(work, fsal_stage, gap):
    """Add y' times `gap` to y; `gap` is a few units in the last place of t."""
    for i in range(work.shape[1]):
        work[Y, i] += gap * work[K + fsal_stage, i]


@njit(**INTERNAL)
def next_segment(kernels, solve, output):
    """Start the next segment, where algebraic components may jump; returns RUNNING or RAISED."""
    s = solve.state[0]
    o = output.record[0]
    mass = solve.block[MASS]
    segments = output.segments
    fsal_stage = kernels.fsal_stage
    o.i_segment += 1
    gap = 0.5 * (segments[o.i_segment, 0] - s.t)  # each side's slope crosses half
    if mass == 0:
        _extrapolate(solve.work, fsal_stage, gap)
    s.t = segments[o.i_segment, 0]
    s.t_end = segments[o.i_segment, 1]
    s.order = 0
    if mass != 0 and not made_consistent(mass, s.t, slot(None, solve.work, Y)):
        return RAISED
    status = derive(solve, fsal_stage)
    if mass == 0:
        _extrapolate(solve.work, fsal_stage, gap)
    return status


@njit(**INTERNAL)
def jumps_over(s, o, output):
    """Look whether the last step jumped over two changes; True for the first such step of a solve.

    That is, the method evaluated the equations at no time between the two.  A single change is seen
    at the next evaluation.
    """
    changes = output.changes
    before = o.jumped
    i = o.i_change
    h = s.t - s.t_old
    while i + 1 < len(changes) and s.direction * (changes[i + 1] - s.t) <= 0.0:
        looked = s.direction * (changes[i] - s.t_old) < 0.0
        for share in output.looks:
            t = s.t_old + share * h
            between = (
                s.direction * (t - changes[i]) > 0.0 and s.direction * (changes[i + 1] - t) > 0.0
            )
            looked = looked or between
        if not looked and o.jumped == 0:
            o.jumped = i + 1
        i += 1
    o.i_change = i
    return o.jumped != before
