"""Options of steps: tolerances, step sizes, the segments of a span with breakpoints."""

import math
import warnings

import numpy as np

from fastdyn.compile.callables.diagnostics import levels_inside

EPS = float(np.finfo(float).eps)
LATEST = 2.0**1022  # of times: the distance of two is finite
LANDING = 1e-9  # relative distance at which a span counts as a whole number of steps
NO_SEGMENTS = np.empty((0, 3))


def _tolerance(value, name, n):
    if value.__class__ is not float:
        value = np.asarray(value, dtype=float)
        if value.ndim and value.shape != (n,):
            raise ValueError(f"`{name}` has wrong shape.")
        if np.isnan(value).any():
            raise ValueError(f"`{name}` must not be NaN.")
    elif value != value:
        raise ValueError(f"`{name}` must not be NaN.")
    return value


def tolerances(rtol, atol, y0, least=100 * EPS):
    """`rtol`, `atol`: scalars or arrays of n numbers; rtol is at least `least`."""
    if rtol.__class__ is float is atol.__class__ and rtol >= least and atol > 0:
        return rtol, atol
    rtol, atol = _tolerance(rtol, "rtol", len(y0)), _tolerance(atol, "atol", len(y0))
    if np.any(rtol < least):
        warnings.warn(
            "At least one element of `rtol` is too small. "
            f"Setting `rtol = np.maximum(rtol, {least})`.",
            stacklevel=levels_inside(),
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
        raise ValueError("`first_step` exceeds bounds.")
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


def segments_of_span(breakpoints, t0, tf):
    """Start, end, and output time of the end, of each segment; no rows if `breakpoints` is None.

    Segments end a few roundings of the time before the breakpoint and begin as far behind, so that
    a derivative with a jump is evaluated on the right side.
    """
    if breakpoints is None:
        return NO_SEGMENTS
    times = np.asarray(breakpoints, dtype=float)
    if times.ndim != 1 or np.isnan(times).any():
        raise ValueError("`breakpoints` must be a 1-D array of times that are not NaN.")
    first, last = min(t0, tf), max(t0, tf)
    times = np.unique(times[(times >= first) & (times <= last)])
    off = 4 * EPS * np.abs([*times, t0, tf if math.isfinite(tf) else t0]).max()
    begins, ends = np.any(times <= first + 4 * off), np.any(times >= last - 4 * off)
    times = times[(times > first + 4 * off) & (times < last - 4 * off)]
    times = times[np.r_[np.ones(len(times[:1]), bool), np.diff(times) > 4 * off]]
    if tf < t0:
        times, off, begins, ends = times[::-1], -off, ends, begins
    tf = last_time(tf)
    starts = np.r_[t0 + begins * off, times + off]
    stops = np.r_[times - off, tf - ends * off if ends else tf]
    return np.column_stack([starts, stops, np.r_[times, tf]])
