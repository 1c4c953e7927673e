"""Options of steps: tolerances, step sizes, the segments of a span with breakpoints."""

import bisect
import math

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.words.kinds import noted

EPS = float(np.finfo(float).eps)
LATEST = 2.0**1022  # of times: the distance of two is finite
LANDING = 1e-9  # relative distance at which a span counts as a whole number of steps
NO_SEGMENTS = np.empty((0, 3))


def _tolerance(value, name, n):
    if value.__class__ is not float:
        value = np.array(value, dtype=float)  # a solver for the next call keeps the tolerances
        if value.ndim and value.shape != (n,):
            raise noted(
                ValueError(f"`{name}` has wrong shape."),
                f"It has shape {value.shape}, and `y0` has {n} components.",
            )
        if np.isnan(value).any():
            raise ValueError(f"`{name}` must not be NaN.")
    elif value != value:
        raise ValueError(f"`{name}` must not be NaN.")
    return value


def tolerances(rtol, atol, y0, least=100 * EPS):
    """`rtol`, `atol`: scalars or arrays of n numbers; rtol is at least `least`."""
    if rtol.__class__ is float is atol.__class__ and rtol >= least and atol > 0:
        return rtol, atol
    rtol = _tolerance(rtol, "rtol", len(y0))
    atol = _tolerance(atol, "atol", len(y0))
    if np.any(rtol < 0):
        raise ValueError(f"`rtol` must not be negative; got {rtol}.")
    if np.any(rtol < least):
        warn(
            "At least one element of `rtol` is too small. "
            f"Setting `rtol = np.maximum(rtol, {least})`."
        )
        rtol = np.maximum(rtol, least)
    if np.any(atol < 0):
        raise ValueError("`atol` must be positive.")
    if np.any(atol == 0):
        bare = np.flatnonzero((np.broadcast_to(atol, y0.shape) == 0) & (y0 == 0))
        if bare.size:
            raise ValueError(
                f"`atol` is 0 where `y0` is 0 (component {bare[0]}): no error is small enough "
                "there; give that component a positive `atol`."
            )
    return rtol, atol


def step_limits(options, span):
    """`max_step` (None if not given) and `first_step` (0 if not given)."""
    h_max = options.get("max_step")
    if h_max is not None and not h_max > 0:
        raise ValueError("`max_step` must be positive.")
    first = options.get("first_step")
    if first is None:
        return h_max, 0.0
    if not first > 0:
        raise ValueError("`first_step` must be positive.")
    if first > span:
        raise noted(
            ValueError("`first_step` exceeds bounds."),
            f"`first_step={first}` is longer than `t_span`, {span:g}.",
        )
    return h_max, float(first)


def last_time(tf):
    """The end of the span `tf` for kernels: a step to there is finite, from any time before."""
    return math.copysign(LATEST, tf) if math.isinf(tf) else tf


def never_ends(h_max, t0, tf):
    """Refuse a longest step with which the span takes more than 1e14 steps."""
    if math.isfinite(tf) and 10 * math.ulp(t0) <= h_max < 10 * math.ulp(max(abs(t0), abs(tf))):
        raise ValueError(
            f"`max_step={h_max}` is less than the spacing of numbers near t = {tf}: the run would "
            "take centuries, and fail there."
        )


def fixed_step(options, t0, tf, name):
    """The constant step, adjusted by round-off if the span is a whole number of steps."""
    span = abs(tf - t0)
    step = options.get("step")
    if step is None:
        raise ValueError(f"`method={name!r}` takes constant steps: give their size as `step`.")
    step = float(step)
    if not (step > 0 and math.isfinite(step)):
        raise ValueError(f"`step` must be positive and finite; got {step}.")
    largest = max(abs(t) for t in (t0, tf) if math.isfinite(t))
    if step < math.ulp(largest):
        raise ValueError(
            f"`step={step}` is less than the spacing of numbers at t = {largest}: "
            "the time would stand still."
        )
    n = round(span / step) if math.isfinite(span) else 0
    return span / n if n and abs(n * step - span) <= LANDING * step else step


def within(breakpoints, t0, tf):
    """The breakpoints in a span, ends included; None if there are none."""
    if breakpoints is None:
        return None
    times = np.asarray(breakpoints, dtype=float)
    inside = times[(times >= min(t0, tf)) & (times <= max(t0, tf))]
    return inside if inside.size else None


def warn_of_breakpoints(breakpoints, t0, tf):
    """Warn if there are breakpoints, and each is outside of the span."""
    if breakpoints is None or within(breakpoints, t0, tf) is not None:
        return
    if np.size(breakpoints) and not np.isnan(np.asarray(breakpoints, float)).any():
        warn(f"`breakpoints` have no effect: none is within `t_span`, from {t0:g} to {tf:g}.")


def segments_of_span(breakpoints, t0, tf):
    """Start, end, and output time of the end, of each segment; no rows if `breakpoints` is None."""
    if breakpoints is None:
        return NO_SEGMENTS
    times = np.asarray(breakpoints, dtype=float)
    if times.ndim != 1 or np.isnan(times).any():
        raise ValueError("`breakpoints` must be a 1-D array of times that are not NaN.")
    way = 1.0 if tf >= t0 else -1.0
    u = np.sort(way * times)  # rises along the span
    listed = u.tolist()
    early = bisect.bisect_left(listed, way * t0)
    late = bisect.bisect_right(listed, way * tf)
    off = _off(u[early:late], t0, tf)
    first = bisect.bisect_right(listed, way * t0 + 4 * off, early, late)
    last = bisect.bisect_left(listed, way * tf - 4 * off, early, late)
    begin = t0 + way * off if first > early else t0
    tf = last_time(tf)
    end = tf - way * off if last < late else tf
    u = u[first:last]
    if len(u) > 1:
        apart = u[1:] - u[:-1] > 4 * off
        if not apart.all():
            u = u[np.concatenate([[True], apart])]
    times = way * u
    found = np.empty((len(u) + 1, 3))
    found[0, 0] = begin
    found[1:, 0] = times + way * off
    found[:-1, 1] = times - way * off
    found[:-1, 2] = times
    found[-1, 1:] = end, tf
    return found


def largest_time(times, t0, tf):
    """The largest time of a span; of an endless one, the largest of `times`, or None, within."""
    if math.isfinite(tf):
        return max(abs(t0), abs(tf))
    found = np.abs([] if times is None else times)
    return float(found[np.isfinite(found)].max(initial=abs(t0)))


def unit_of_times(as_scipy, t0, tf):
    """The time that times of events are resolved to beside their own size; 1 as by SciPy."""
    return 1.0 if as_scipy else min(1.0, abs(tf - t0))


def _off(u, t0, tf):
    """The distance of segments from the breakpoints u within the span."""
    return 4 * EPS * largest_time(u, t0, tf)


def segments_of_members(member, times, t0, tf, count):
    """Segments of the spans of `count` members, and the first row of each, and the number of rows.

    Segments end a few roundings of the time before the breakpoint and begin as far behind, so that
    a derivative with a jump is evaluated on the right side.  Those of a single member are the same
    as by `segments_of_span`.

    Parameters
    ----------
    member : ndarray of int
        The member to which each time belongs.
    times : ndarray
        Breakpoints in any order.
    """
    way = 1.0 if tf >= t0 else -1.0
    u = way * times  # rises along the span
    inside = (u >= way * t0) & (u <= way * tf)
    order = np.lexsort((u[inside], member[inside]))
    u = u[inside][order]
    member = member[inside][order]
    off = _off(u, t0, tf)
    early = u <= way * t0 + 4 * off
    late = u >= way * tf - 4 * off
    begins, ends = np.zeros((2, count))
    begins[member[early]] = ends[member[late]] = way * off
    keep = ~(early | late)
    keep[1:] &= (u[1:] - u[:-1] > 4 * off) | (member[1:] != member[:-1]) | early[:-1]
    times = way * u[keep]
    member = member[keep]
    tf = last_time(tf)
    rows = np.zeros(count + 1, int)
    rows[1:] = (np.bincount(member, minlength=count) + 1).cumsum()
    at = np.arange(len(times)) + member
    found = np.empty((len(times) + count, 3))
    found[rows[:-1], 0] = t0 + begins
    found[rows[1:] - 1, 1] = tf - ends
    found[rows[1:] - 1, 2] = tf
    found[at + 1, 0] = times + way * off
    found[at, 1] = times - way * off
    found[at, 2] = times
    return found, rows
