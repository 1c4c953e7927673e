"""Events and folds on vectors of trajectories."""

from ..jit.options import INLINED, njit
from ..vector.scalar_or_vector import select
from .lanes import field, leave

NEAR = 1e-6  # an event function below this share of its change in a step counts as a crossing


@njit(**INLINED)
def crossed(g, row, form, t, y, ok, block, lanes):
    """The lanes in which an event function has changed its sign, or nearly.

    Row `row` has the last value of the function.
    """
    old = field(form, lanes, row)
    new = g(t, y, block)
    leave(form, lanes, row, select(ok, new, old))
    return ok & ((abs(new) <= NEAR * abs(new - old)) | ~(old * new > 0.0))


@njit(**INLINED)
def accumulate(update, row, form, t, y, on, block, lanes):
    """Let the value in `row` be ``update(t, [value, y])`` where `on` holds."""
    old = field(form, lanes, row)
    leave(form, lanes, row, select(on, update(t, (old, *y), block), old))
