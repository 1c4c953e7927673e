"""Events and folds on vectors of trajectories."""

from ..jit.options import INLINED, njit
from ..output.series_roots.look import FADES, may_turn, second_difference
from ..output.series_roots.phases import LIMIT, QUARTER
from ..state.elementwise import apply
from ..vector.scalar_or_vector import select
from .lanes import field, leave

NEAR = 1e-6  # an event function below this share of its change in a step counts as a crossing


@njit(**INLINED)
def crossed(g, row, form, at, at_new, ok, block, lanes):
    """The lanes in which an event function has changed its sign, or nearly.

    Row `row` has the last value of the function.
    """
    t_new, y_new, _ = at_new
    old = field(form, lanes, row)
    new = g(t_new, y_new, block)
    leave(form, lanes, row, select(ok, new, old))
    return ok & ((abs(new) <= NEAR * abs(new - old)) | ~(old * new > 0.0))


@njit(**INLINED)
def crossed_inside(g, row, form, at, at_new, ok, block, lanes):
    """The lanes in which an event function has changed its sign, or may have, twice.

    Row `row + 1` has the largest second difference of late.
    """
    (t, y, f) = at
    (t_new, y_new, f_new) = at_new
    (middle,) = apply(_middle, (None,), (t_new - t,), (y, y_new, f, f_new))
    old = field(form, lanes, row)
    between = g(0.5 * (t + t_new), middle, block)
    new = g(t_new, y_new, block)
    leave(form, lanes, row, select(ok, new, old))
    before = FADES * field(form, lanes, row + 1)
    now = second_difference(old, between, new)
    bend = select(now > before, now, before)
    leave(form, lanes, row + 1, select(ok, bend, field(form, lanes, row + 1)))
    near = abs(new) <= NEAR * abs(new - old)
    return ok & (near | ~(old * new > 0.0) | may_turn(old, between, new, bend))


def or_fast(crossed, phases, n_absolute, n_periodic, n_phases):
    """As `crossed`, and the lanes in which a function changes much more than the solution.

    ``phases(t, y, block)`` returns the phases of `output/series_roots/phases.py`: the first
    `n_periodic` of them are periodic, those from `n_absolute` on divisors.
    """
    together = None
    for j in range(n_phases):
        unit = 1.0 if n_periodic <= j < n_absolute else 0.0
        together = _with_phase(together, j, j < n_periodic, unit)

    @njit(**INLINED)
    def crossed_or_fast(g, row, form, at, at_new, ok, block, lanes):
        (t, y, f) = at
        (t_new, y_new, f_new) = at_new
        (middle,) = apply(_middle, (None,), (t_new - t,), (y, y_new, f, f_new))
        fast = together(
            phases(t, y, block),
            phases(0.5 * (t + t_new), middle, block),
            phases(t_new, y_new, block),
        )
        return crossed(g, row, form, at, at_new, ok, block, lanes) | (ok & fast)

    return crossed_or_fast


def _with_phase(others, j, periodic, unit):
    @njit(**INLINED)
    def last(start, middle, end):
        before = start[j]
        between = middle[j]
        after = end[j]
        low = _less(_less(before, between), after)
        high = -_less(_less(-before, -between), -after)
        change = high - low
        if periodic:
            return change > LIMIT * QUARTER
        near = -_less(-low, high) - change  # of low and -high the larger one
        return change > LIMIT * (unit - _less(-near, 0.0 * near))

    if others is None:
        return last

    @njit(**INLINED)
    def together(start, middle, end):
        return others(start, middle, end) | last(start, middle, end)

    return together


@njit(**INLINED)
def _less(a, b):
    return select(a < b, a, b)


@njit(**INLINED)
def _middle(h, y, y_new, f, f_new):
    return (0.5 * (y + y_new) + 0.125 * h * (f - f_new),)


@njit(**INLINED)
def accumulate(update, row, form, t, y, on, block, lanes):
    """Let the value in `row` be ``update(t, [value, y])`` where `on` holds."""
    old = field(form, lanes, row)
    leave(form, lanes, row, select(on, update(t, (old, *y), block), old))
