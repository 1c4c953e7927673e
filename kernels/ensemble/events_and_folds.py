"""Events and folds on vectors of trajectories."""

from ..jit.options import INLINED, njit
from ..output.series_roots.look import FADES, may_turn, second_difference
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


@njit(**INLINED)
def _middle(h, y, y_new, f, f_new):
    return (0.5 * (y + y_new) + 0.125 * h * (f - f_new),)


@njit(**INLINED)
def accumulate(update, row, form, t, y, on, block, lanes):
    """Let the value in `row` be ``update(t, [value, y])`` where `on` holds."""
    old = field(form, lanes, row)
    leave(form, lanes, row, select(on, update(t, (old, *y), block), old))
