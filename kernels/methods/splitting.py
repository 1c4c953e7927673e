"""Explicit symplectic steps for q'' = a(t, q): alternating kicks and drifts, from a table of sizes.

A step is  kick p_0, drift q_1, kick p_1, ..., drift q_s, kick p_s.  The acceleration at the end
serves the first kick of the next step, so that a step takes s evaluations.  For H = T(p) + V(q),
positions drift by dT/dp instead of p.  The force is evaluated at the time that the drifts have
reached, dT/dp at the time that the kicks have reached.

Positions and velocities are sums with compensation of rounding errors (W. Kahan, Comm. ACM 8
(1965)).  After 10^5 revolutions, the error of an orbit is then a random walk instead of a
systematic drift.  The compensation takes a tenth of the time.
"""

from functools import partial

import numpy as np

from ..calls.velocity_force import velocity_by_pointer
from ..ensemble import lanes
from ..jit.options import INLINED, njit
from ..output.dense_output import cubic
from ..state.elementwise import apply, assign, halves, join
from ..state.record import K, Y
from ..state.rows import slot
from ..stepping import first_step, fixed
from .method import method
from .within_steps import OWN, ROWS, n_shorter, write_dense_rows

LAST = 1  # the stage with the derivative at the end


@njit(**INLINED)
def _added(c, high, compensation, k):
    part = compensation + c * k
    total = high + part
    return total, part - (total - high)


@njit(**INLINED)
def add_compensated(out, compensation_out, high, compensation, c, k):
    """Add c k to high + compensation: the new (high, compensation).

    The new compensation is the rounding error of the new sum.
    """
    return apply(_added, (out, compensation_out), (c,), (high, compensation, k))


def palindrome(first, n):
    """A symmetric table of n entries from its first half, the middle entry included."""
    first = [float(word) for word in first.split()]
    whole = first + first[: n - len(first)][::-1]
    assert len(whole) == n
    return np.array(whole)


def of_verlet_steps(fractions):
    """(kicks, drifts) of a composition of Verlet steps; `fractions` are the sizes of the steps."""
    halved = 0.5 * fractions
    return np.r_[halved[0], halved[1:] + halved[:-1], halved[-1]], fractions


@njit(**INLINED)
def itself(t, v, block, place):
    """The rate of the positions if `v` is the velocity."""
    return v


def make_step(kicks, drifts, velocity):
    """The step of a table of s + 1 kicks and s drifts, which drift by ``velocity(t, v, ...)``."""
    s = len(drifts)
    times, kicked = np.cumsum(drifts), np.cumsum(kicks)
    times[-1] = 1.0

    @njit(**INLINED)
    def step(acceleration, t, y, h, k1, compensation, block, form, work):
        q, v = halves(y)
        _, a = halves(k1)
        q_carry, v_carry = halves(compensation)
        place = slot(form, work, Y)
        end = slot(form, work, K + LAST)
        cut = slot(form, work, K + 2)
        q_place, v_place = halves(place)
        rate_place, a_place = halves(end)
        q_cut, v_cut = halves(cut)
        v, v_carry = add_compensated(v_place, v_cut, v, v_carry, kicks[0] * h, a)
        rate = velocity(t + kicked[0] * h, v, block, rate_place)
        q, q_carry = add_compensated(q_place, q_cut, q, q_carry, drifts[0] * h, rate)
        for i in range(1, s):
            a = acceleration(t + times[i - 1] * h, q, block, a_place)
            v, v_carry = add_compensated(v_place, v_cut, v, v_carry, kicks[i] * h, a)
            rate = velocity(t + kicked[i] * h, v, block, rate_place)
            q, q_carry = add_compensated(q_place, q_cut, q, q_carry, drifts[i] * h, rate)
        a = acceleration(t + h, q, block, a_place)
        v, v_carry = add_compensated(v_place, v_cut, v, v_carry, kicks[s] * h, a)
        rate = assign(rate_place, v)
        return join(place, q, v), (k1, join(end, rate, a), join(cut, q_carry, v_carry))

    return step


def composed(name, order, kicks, drifts, quadratic=False):
    """A Method of kicks and drifts; `quadratic` methods need T = v² / 2."""

    def looped(loop, velocity):
        return partial(loop, make_step(kicks, drifts, velocity), LAST, LAST + 1)

    m = n_shorter(order)
    written = partial(write_dense_rows, name, partial(make_step, kicks, drifts))
    return method(
        name, order=order, error_order=0, n_stages=len(drifts), n_rows=OWN + (ROWS if m else 0),
        fsal_stage=LAST,
        kernel=looped(fixed.kernel, itself), lane_kernel=looped(lanes.fixed, itself),
        start=first_step.second_order, n_dense=3 + 2 * m,
        dense_rows=written(itself, len(drifts), m) if m else cubic,
        dense_order=min(order, 3 + 2 * m),
        rows_of_pair=None if quadratic else partial(written, velocity_by_pointer, len(drifts), m),
        second_order=True, separable=None if quadratic else partial(looped, fixed.kernel),
        projects=False, backward="kicks", tableau={"kicks": kicks, "drifts": drifts},
    )  # fmt: skip
