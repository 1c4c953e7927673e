"""Why a run has stopped: its equations are nan or inf just after, as in the gap of a record."""

import numpy as np

from fastdyn.compile.compare import machine_value, python_value

# Distances at which the equations are called, as shares of the way to the end.  Steps that failed
# were as short as a few spacings of the time.
AHEAD = (1e-14, 1e-12, 1e-10, 1e-8, 1e-6)
PARTS, HALVINGS = 64, 20  # to find the end of a gap


def of_undefined(problem, bound, t, y, h=0.0):
    """The sentence about equations that are nan or inf just after a state; "" for others.

    The next step, of length h, may have met them.
    """
    p = problem
    lost = not np.isfinite(y).all()
    if bound.pair:
        return ""
    y = p.y0.copy() if lost else y.copy()  # a lost state: whether they are undefined at any
    if lost and not _defined(bound, t - 1e-3 * (t - p.t0), y):
        return ""
    way = p.tf - t if np.isfinite(p.tf) else np.copysign(max(abs(t - p.t0), 1.0), p.tf)
    times = [t + np.copysign(max(abs(share * way), 2 * np.spacing(abs(t))), way) for share in AHEAD]
    times += [t + np.copysign(h, way) * k / 8 for k in range(1, 9) if 0.0 < h <= abs(way)]
    if (begin := _first(lambda at: y, bound, t, times)) is not None:
        return _of_gap(bound, begin, t + way, y)
    rate = _value(bound, t, y)
    if lost or len(rate) != len(y) or not np.isfinite(rate).all():
        return ""
    begin = _first(lambda at: y + (at - t) * rate, bound, t, times)
    return "" if begin is None else f"`fun` returns nan or inf just after t = {begin:.10g}."


def _first(state, bound, t, times):
    """The last time before the equations are not defined at one of the times; None if they are."""
    before = t
    for at in times:
        if not _defined(bound, at, state(at)):
            return before if at is times[0] else _between(state, bound, before, at)
        before = at
    return None


def _of_gap(bound, t, tf, y):
    """The sentence about equations that are nan or inf from a time on, looked at up to tf."""
    ends = np.linspace(t, tf, PARTS + 1)[1:]
    after = next((k for k, at in enumerate(ends) if _defined(bound, at, y)), None)
    if after is None:
        return f"`fun` returns nan or inf at all times after t = {t:.10g}: end the span there."
    end = _between(lambda at: y, bound, ends[after], ends[after - 1] if after else t)
    return (
        f"`fun` returns nan or inf just after t = {t:.10g}, up to t = {end:.5g}, as a record with "
        "a gap does: fill the gap, or end the span before it."
    )


def _between(state, bound, defined, undefined):
    """A time where the equations are defined, near one where they are not."""
    for _ in range(HALVINGS):
        middle = 0.5 * (defined + undefined)
        if _defined(bound, middle, state(middle)):
            defined = middle
        else:
            undefined = middle
    return defined


def _value(bound, t, y):
    found = (python_value if bound.function is None else machine_value)(bound, t, y)
    return np.full(len(y), np.nan) if found is None or isinstance(found, Exception) else found


def _defined(bound, t, y):
    return bool(np.isfinite(_value(bound, t, y)).all())
