"""The steps of Rodas5P with a trajectory in each lane of a vector, for M y' = f(t, y).

df/dy and df/dt are exact.  A lane with a number that is not finite, for example because its matrix
is singular, is left to the step of `step.py`.
"""

import numpy as np

from ...algebra.elimination_in_lanes import make_elimination, make_product
from ...algebra.mass_in_lanes import make_mass_product, make_numbers
from ...ensemble import lanes
from ...jit.options import INLINED, INTERNAL, njit
from ...state.elementwise import apply, combine, weigh
from ...state.record import K
from ...state.reduce import add, reduce_components
from ...state.rows import rows_on_stack
from ...stepping.step_size import SCIPY, rms
from ...vector.scalar_or_vector import select
from .derivatives import SLOPE
from .table import END, GAMMA, N_STAGES, SLOPES, TIMES, A, C

TRIED, ACCEPTED = 7, 1  # evaluations in each step, and after an accepted step


@njit(**INTERNAL)
def _add(a, b):
    return (a + b,)


@njit(**INTERNAL)
def _product(a, b):
    return (a * b,)


@njit(**INTERNAL)
def _moved(factor, old, new):
    return (factor * (old - new),)


@njit(**INTERNAL)
def _add_multiple(factor, a, b):
    return (a + factor * b,)


@njit(**INTERNAL)
def _add_zero_times(total, x):
    """The total, or NaN if x is not finite."""
    return total + 0.0 * x


@njit(**INLINED)
def _sum(a, b):
    return apply(_add, (None,), (), (a, b))[0]


@njit(**INLINED)
def _without_mass(block):
    return None


@njit(**INLINED)
def _add_to(block, x, total):
    """``M x + total`` of an M that is the identity."""
    return _sum(total, x)


def _make_with_time(slope, timed):
    """``with_time(f, h, by_time)``: f + h slope df/dt."""

    @njit(**INLINED)
    def with_time(f, h, by_time):
        return apply(_add_multiple, (None,), (h * slope,), (f, by_time))[0]

    @njit(**INLINED)
    def without(f, h, by_time):
        return f

    return with_time if timed and slope != 0.0 else without


def _make_first_stage(solve, timed):
    with_time = _make_with_time(GAMMA, timed)
    b = END.floats[0]

    @njit(**INLINED)
    def stages(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged):
        right = with_time(k1, h, by_time)
        return (solve(factors, exchanged, right),), y, apply(_product, (None,), (b,), (right,))[0]

    return stages


def _make_state(i):
    """``state(y, before, u)``: the state of stage i, from the state before and the stages u."""
    row = A[min(i, len(A)) - 1]

    @njit(**INLINED)
    def combined(y, before, u):
        return combine(None, y, 1.0, row, u)

    @njit(**INLINED)
    def gone_on(y, before, u):
        return _sum(before, u[i - 1])

    return combined if i <= len(A) else gone_on


def _and_stage(before, i, solve, timed, add_product):
    """A function that solves for the stages up to stage i.

    The function returns the stages, the state of stage i, and the sum of
    b_j (f_j + h slope_j df/dt).
    """
    state, with_time = _make_state(i), _make_with_time(SLOPES.floats[i], timed)
    c = C[i - 1]
    time = TIMES.floats[i - 1]
    b = END.floats[i]

    @njit(**INLINED)
    def stages(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged):
        u, last, total = before(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged)
        now = state(y, last, u)
        f = with_time(rhs(t + time * h, now, block, None), h, by_time)
        right = add_product(block, weigh(None, 1.0 / h, c, u), f)
        total = apply(_add_multiple, (None,), (b,), (total, f))[0]
        return (*u, solve(factors, exchanged, right)), now, total

    return stages


def _and_last_stage(before, solve, multiply, add_product):
    """A function that solves for all stages; for the last stage see `step.py`."""
    state = _make_state(N_STAGES - 1)
    time = TIMES.floats[-1]

    @njit(**INLINED)
    def stages(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged):
        u, last, total = before(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged)
        now = state(y, last, u)
        f = rhs(t + time * h, now, block, None)
        total = multiply(jacobian, weigh(None, 1.0, END, u), total)
        moved = apply(_moved, (None,), (1.0 / (h * GAMMA),), (y, now))[0]
        right = add_product(block, moved, _sum(f, total))
        return (*u, solve(factors, exchanged, right)), now

    return stages


def _make_stages(solve, multiply, timed, add_product):
    """A function that returns all stages, and the state of the last stage."""
    stages = _make_first_stage(solve, timed)
    for i in range(1, N_STAGES - 1):
        stages = _and_stage(stages, i, solve, timed, add_product)
    return _and_last_stage(stages, solve, multiply, add_product)


def _make_step(derivatives, form):
    """The step for `lanes.adaptive`; its error is negative in lanes with a non-finite number."""
    width, n_entries = form.value.dtype.width, len(derivatives.rows)
    places = (derivatives.rows, derivatives.columns)
    mass = derivatives.mass
    room, factorise, solve = make_elimination(*places, form, mass)
    numbers_of_mass = _without_mass
    add_product = _add_to
    if mass is not None:
        numbers_of_mass = make_numbers(len(mass[0]), form)
        add_product = make_mass_product(*mass, form)
    stages = _make_stages(solve, make_product(*places), derivatives.timed, add_product)
    derive = derivatives.function

    @njit(**INLINED)
    def step(rhs, t, y, h, k1, block, form, work, rtol, atol):
        found = derive(t, y, block, None)
        factors = rows_on_stack(room, width)
        jacobian = found[:n_entries]
        by_time = found[n_entries:]
        exchanged = factorise(factors, jacobian, 1.0 / (h * GAMMA), numbers_of_mass(block))
        u, last = stages(rhs, t, y, h, k1, block, jacobian, by_time, factors, exchanged)
        y_new = _sum(last, u[-1])
        # With an infinite entry of the Jacobian, stages and error would be zero.
        doubt = reduce_components(_add_zero_times, add, 0.0, (found,))
        error = rms(u[-1], y, y_new, rtol, atol) + doubt
        slope = rhs(t + h, y_new, block, None)
        return y_new, (k1, slope, *u), select(error < np.inf, error, -1.0)

    return step


def kernel(rhs, form, extrema, watched, accumulated, derivatives):
    """The loop of `lanes.adaptive` around `rhs` and its `method.Derivatives`."""
    step = _make_step(derivatives, form)
    counted = (TRIED, ACCEPTED)
    return lanes.adaptive(
        step, SCIPY, -0.2, SLOPE - K, rhs, form, extrema, watched, accumulated, counted
    )
