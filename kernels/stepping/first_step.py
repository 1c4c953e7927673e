"""Before the first step: the derivative at t_start and the size of the step to try.

A start kernel is ``start(state, work, block, order, fsal_stage)``.  The kernel leaves the
derivative in row K + fsal_stage, where the loops expect the derivative, and the step size in
``state.h`` unless the caller has set ``state.h``.  The kernel returns RUNNING, RAISED, or
NON_FINITE if the derivative is not finite.
"""

import numpy as np

from ..calls.block import MASS, RAISED_WORD
from ..calls.consistent import evaluations_since, is_consistent, rates_of
from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.elementwise import halves
from ..state.record import ATOL, NON_FINITE, RAISED, RTOL, RUNNING, STAGE, K, Y
from ..state.rows import slot

EPS = float(np.finfo(float).eps)


@njit(**INTERNAL)
def _status(f):
    """RUNNING, or NON_FINITE if a component of a derivative is not finite."""
    for i in range(len(f)):
        if not np.isfinite(f[i]):
            return NON_FINITE
    return RUNNING


@njit(**INTERNAL)
def plain(state, work, block, order, fsal_stage):
    """The derivative alone, for a step size that is given."""
    s = state[0]
    f = by_pointer(s.t, slot(None, work, Y), block, slot(None, work, K + fsal_stage))
    s.n_extra += 1
    if block[RAISED_WORD] != 0:
        return RAISED
    return _status(f)


@njit(**INTERNAL)
def second_order(state, work, block, order, fsal_stage):
    """The derivative [v, a] of a state [q, v], from the acceleration alone."""
    s = state[0]
    q, v = halves(slot(None, work, Y))
    rate, a = halves(slot(None, work, K + fsal_stage))
    by_pointer(s.t, q, block, a)
    s.n_extra += 1
    for i in range(len(v)):
        rate[i] = v[i]
    if block[RAISED_WORD] != 0:
        return RAISED
    return _status(a)


@njit(**INTERNAL)
def _scaled_rms(values, work):
    total = 0.0
    for i in range(len(values)):
        x = values[i] / (work[ATOL, i] + abs(work[Y, i]) * work[RTOL, i])
        total += x * x
    return np.sqrt(total / len(values))


def make_hairer(name, scaled_rms):
    """The start kernel `name`, with ``scaled_rms(values, work)`` as its norm."""

    def start(state, work, block, order, fsal_stage):
        """The first step of Hairer, Norsett and Wanner, section II.4: one more evaluation."""
        status = plain(state, work, block, order, fsal_stage)
        s = state[0]
        if status != RUNNING or s.h > 0.0:
            return status
        span = abs(s.t_end - s.t)
        if span == 0.0:
            return status
        y = slot(None, work, Y)
        f = slot(None, work, K + fsal_stage)
        u = slot(None, work, STAGE)
        size = scaled_rms(y, work)
        slope = scaled_rms(f, work)
        h = 1e-6 if size < 1e-5 or slope < 1e-5 else 0.01 * size / slope
        h = min(h, span)
        for i in range(len(y)):
            u[i] = y[i] + h * s.direction * f[i]
        probe = by_pointer(s.t + h * s.direction, u, block, slot(None, work, K))
        s.n_extra += 1
        if block[RAISED_WORD] != 0:
            return RAISED
        for i in range(len(y)):
            probe[i] -= f[i]
        curvature = scaled_rms(probe, work) / h
        if slope <= 1e-15 and curvature <= 1e-15:
            longer = max(1e-6, h * 1e-3)
        else:
            longer = (0.01 / (curvature if curvature > slope else slope)) ** (1.0 / (order + 1.0))
        s.h = min(min(100.0 * h, longer), min(span, s.h_max))
        return status

    start.__name__ = name
    return njit(**INTERNAL)(start)


hairer = make_hairer("hairer", _scaled_rms)


@njit(**INTERNAL)
def forget(s, pairs):
    """Let a method begin without a Jacobian and without a past."""
    s.order = s.n_equal = s.factorised = s.current = 0
    s.h_old = 0.0
    s.pairs = pairs


@njit(**INTERNAL)
def implicit(state, work, block, order, fsal_stage):
    """`hairer`, for a method that factorises matrices."""
    forget(state[0], 0)
    if block[MASS] != 0:
        return _with_mass(state, work, block, order, fsal_stage)
    return hairer(state, work, block, order, fsal_stage)


@njit(**INTERNAL)
def _with_mass(state, work, block, order, fsal_stage):
    """`implicit` for M y' = f: the start of a run is checked, the step follows from y'."""
    s = state[0]
    mass = block[MASS]
    status = plain(state, work, block, order, fsal_stage)
    if status != RUNNING:
        return status
    y = slot(None, work, Y)
    rate = slot(None, work, STAGE)
    at_start = s.n_accepted == 0 and s.n_rejected == 0
    if at_start:
        evaluations_since(mass)  # what the last action of an earlier solve left is of that solve
    consistent = not at_start or is_consistent(mass, s.t, y, rate)
    if consistent and s.h <= 0.0:
        rates_of(mass, s.t, y, rate)
        size = _scaled_rms(y, work)
        slope = _scaled_rms(rate, work)
        h = 0.01 * size / slope if size >= 1e-5 and slope >= 1e-5 else 1e-6
        s.h = min(h, min(abs(s.t_end - s.t), s.h_max))
    s.n_extra += evaluations_since(mass)
    return RAISED if block[RAISED_WORD] != 0 or not consistent else RUNNING


@njit(**INTERNAL)
def matlab(state, work, block, order, fsal_stage):
    """The first step of ode45, from the slope, at most a tenth of the span; or the step given."""
    status = plain(state, work, block, order, fsal_stage)
    s = state[0]
    if status != RUNNING:
        return status
    rtol = work[RTOL, 0]
    span = abs(s.t_end - s.t)
    h = min(s.h_max, span)
    if s.h > 0.0:
        s.h = min(s.h, h)
        return status
    steepest = 0.0
    for i in range(work.shape[1]):
        floor = work[ATOL, i] / work[RTOL, i]
        steepest = max(steepest, abs(work[K + fsal_stage, i]) / max(abs(work[Y, i]), floor))
    steepest /= 0.8 * rtol ** (1.0 / (order + 1.0))
    s.h = 1.0 / steepest if h * steepest > 1.0 else h
    return status


@njit(**INTERNAL)
def lsoda(state, work, block, order, fsal_stage):
    """The first step of LSODA, from the slope and the times; no evaluation.

    K. Radhakrishnan and A. C. Hindmarsh, "Description and use of LSODE", NASA RP-1327 (1993),
    section 2.8, with the largest component for the norm.  If steps may pass the end, the first
    time of output, t_stop, takes the place of the end.
    """
    s = state[0]
    s.order = 0
    status = plain(state, work, block, order, fsal_stage)
    if status != RUNNING:
        return status
    t_end = s.t_stop if s.passes_end else s.t_end
    span = abs(t_end - s.t)
    given = s.h > 0.0
    if not given:
        rtol = 0.0
        steepest = 0.0
        for i in range(work.shape[1]):
            rtol = max(rtol, work[RTOL, i])
            tolerance = work[RTOL, i] * abs(work[Y, i]) + work[ATOL, i]
            steepest = max(steepest, abs(work[K + fsal_stage, i]) * (1.0 / tolerance))
        rtol = min(max(rtol, 100.0 * EPS), 0.001)
        late = max(abs(s.t), abs(t_end))
        s.h = 1.0 / np.sqrt(1.0 / (rtol * late * late) + rtol * steepest * steepest)
    if s.passes_end:
        span = abs(s.t_limit - s.t) if given else min(span, abs(s.t_limit - s.t))
    s.h = min(s.h, span)
    if s.h == 0.0:  # a square is out of range
        s.h = span
    if s.h == np.inf:  # the state is at rest, and the span has no end
        s.h = 1.0
    s.h = min(s.h, s.h_max)
    return status
