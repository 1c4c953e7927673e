"""The product G(t, y) w of a diffusion and a noise, for one function or one for each column of G.

`drift` and the functions of a diffusion are ``f(t, y, block, out)``, as the right-hand side of a
step; `out` is a row of the work array, or None on vectors.
"""

from ..jit.options import INLINED, njit
from ..state.elementwise import apply
from ..state.rows import fetch, slot
from .arguments import G


@njit(**INLINED)
def _by_component(start, g, w):
    return (start + g * w,)


@njit(**INLINED)
def by_factor(factor, start, g):
    return (start + g * factor,)


def diagonal(function):
    """start + g(t, y) w, where component i of the noise acts on component i of the state."""

    @njit(**INLINED)
    def spread(place, start, t, y, w, block, form, work):
        g = function(t, y, block, slot(form, work, G))
        return apply(_by_component, (place,), (), (start, g, w))[0]

    return spread


def columns(functions):
    """start + sum(g_j(t, y) w_j), where g_j is column j of G."""
    together = None
    for j, function in enumerate(functions):
        together = _with_column(together, function, j)
    return together


def _with_column(before, function, j):
    @njit(**INLINED)
    def last(place, start, t, y, w, block, form, work):
        g = function(t, y, block, slot(form, work, G))
        return apply(by_factor, (place,), (w[j],), (start, g))[0]

    if before is None:
        return last

    @njit(**INLINED)
    def both(place, start, t, y, w, block, form, work):
        others = before(place, start, t, y, w, block, form, work)
        return last(place, others, t, y, w, block, form, work)

    return both


@njit(**INLINED)
def noise_of(of_noise, noise, row):
    """A row of the noise as a value with one component for each source."""
    return fetch(of_noise, noise, row)
