"""The loop over paths and steps: each block of lanes goes from one output time to the next."""

from ..jit.options import INLINED, INTERNAL, njit
from ..state.elementwise import apply, assign, halves
from ..state.record import RUNNING
from ..state.rows import fetch, keep, slot, vector_at
from ..vector.scalar_or_vector import select
from .arguments import OUT, SLOPE, Y
from .brownian import draw


@njit(**INTERNAL)
def _load(y, path, work, width):
    for j in range(len(y)):
        for lane in range(width):
            work[Y, j * width + lane] = y[j, path + lane]


@njit(**INTERNAL)
def _store(y, path, work, width):
    for j in range(len(y)):
        for lane in range(width):
            y[j, path + lane] = work[Y, j * width + lane]


@njit(**INLINED)
def _begin(r):
    """The time of the first step, to the bits that a step before gives."""
    if r.begin == 0:
        return r.t0
    return (r.t0 + (r.begin - 1) * r.h) + r.h


@njit(**INLINED)
def _number_at(row, path):
    return row[path]


def _vector_of(lanes):
    @njit(**INLINED)
    def vector(row, path):
        return vector_at(lanes, row, path)

    return vector


@njit(**INLINED)
def _chosen(alive, old, new):
    return (select(alive > 0.5, new, old),)


@njit(**INLINED)
def no_acceleration(t, y, block, form, work):
    """What the first step takes as `k` where a method needs no acceleration."""
    return y


def first_acceleration(acceleration):
    """What the first step of a splitting takes as `k`: the acceleration at the start."""

    @njit(**INLINED)
    def start(t, y, block, form, work):
        return acceleration(t, halves(y)[0], block, halves(slot(form, work, SLOPE))[0])

    return start


def kernel(step, start, forms, width, areas, look, settle, leave):
    """``advance(run, block, y, noise, work, *places)``: paths `first` to `last`.

    Parameters
    ----------
    step, start : callable
        Of a method, see `steps.py`.
    forms : (form, of_noise, lanes)
        The forms of the state, of the noise and of one vector.
    width : int
        Paths in a block of lanes; `first` and `last` are multiples of `width`.
    areas : bool
        Whether the step needs the areas of the noise.
    look, settle, leave : callable or None
        What `passages` makes of the events; `leave` is None if no event ends a path.
    """
    form, of_noise, lanes = forms
    stops = leave is not None
    alive_at = _number_at if form is None else _vector_of(lanes)

    @njit(**INTERNAL)
    def advance(run, block, y, noise, work, places):
        r = run[0]
        path = r.first
        while path < r.last:
            r.held = -1
            _load(y, path, work, width)
            state = fetch(form, work, Y)
            k = start(_begin(r), state, block, form, work)
            if look is not None:
                look(-1, r, path, state, block, form, of_noise, work, places)
            for i in range(r.begin, r.end):
                draw(lanes, noise, r, path, i, areas, width)
                new, k = step(r.t0 + i * r.h, state, k, r.h, noise, block, form, of_noise, work)
                if stops:
                    alive = alive_at(places.alive, path)
                    new = apply(_chosen, (slot(form, work, OUT),), (alive,), (state, new))[0]
                if look is not None and look(i, r, path, new, block, form, of_noise, work, places):
                    ended = settle(r.t0 + i * r.h, r.h, path, places)
                    if stops and ended:
                        new = leave(new, state, i, r, path, block, form, of_noise, work, places)
                state = assign(slot(form, work, Y), new)
            keep(work, Y, (state,))
            _store(y, path, work, width)
            path += width
        return RUNNING

    return advance
