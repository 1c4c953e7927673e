"""The kernels for Numba, each a dispatcher and its signature.

This file imports Numba.  A solve imports this file only if a kernel is not on disk yet.  The key of
a kernel covers all that this file imports: what one kind of kernels needs is imported where it is
used, and named where the kernel has its key, in `for_all.py` and `scalar.py`.
"""

import importlib

from fastdyn.code_store import unlinked
from fastdyn.kernels.calls.block import FORCE, VELOCITY
from fastdyn.kernels.calls.user_function import by_pointer, inlined, linked_later
from fastdyn.kernels.calls.velocity_force import (
    both_inlined,
    force_by_pointer,
    part_inlined,
    velocity_by_pointer,
)
from fastdyn.kernels.jit.options import INTERNAL, njit
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.state.layout import Form

from .for_all import FOR_ALL, PLAIN_START
from .signatures import (
    ADVANCE,
    DENSE_ROWS,
    SERIES,
    SERIES_IN_LANES,
    START,
    kernel_of,
)
from .vector_rhs import named, right_hand_side


def for_all(name):
    """A kernel that serves all methods and functions, from the table of these kernels."""
    function, signature = FOR_ALL[name]
    return _named(f"fastdyn.kernels.{function}"), _named(f"fastdyn.specialise.{signature}")


def _named(place):
    """An object of a module by its name."""
    module, _, name = place.rpartition(".")
    return getattr(importlib.import_module(module), name)


def serve(*sample):
    """The kernel in which a worker of an ensemble serves its lanes, for arguments like `sample`."""
    return _named("fastdyn.kernels.ensemble.scheduler.serve"), kernel_of(*sample)


def around_paths(form, *given):
    """The loop over paths of stochastic equations around functions, in one of two forms."""
    make = _named(f"fastdyn.kernels.noise.around.{form}")
    return make(*given), _named("fastdyn.specialise.signatures.noise.PATHS")


def start(method, splits):
    """The start of a method; `splits` tells whether a pair's functions are called separately."""
    place = PLAIN_START if splits else method.start
    return _shared_by_methods(place) or method.code.start, START


def dense_rows(method, splits):
    """The interpolant of a method."""
    rhs = force_by_pointer if splits else by_pointer
    if splits:
        rows = method.code.rows_of_pair()
    else:
        rows = _shared_by_methods(method.dense_rows) or method.code.dense_rows

    @njit(**INTERNAL)
    def kernel(t, h, work, block, d):
        return rows(rhs, t, h, work, block, d)

    return kernel, DENSE_ROWS


def _shared_by_methods(place):
    """A function that several methods may share, by its place; None if a method has made it."""
    return _named(f"fastdyn.kernels.{place}") if "." in place else None


def shared(method, splits):
    """The loop of a method for any function, or for the velocity and the force of a pair."""
    if splits:
        return method.code.separable(velocity_by_pointer)(force_by_pointer, None), ADVANCE
    return method.code.kernel(by_pointer, None), ADVANCE


def series(order, width):
    """The loop of Taylor around the series of any function, in vectors of `width` lanes."""
    return _named("fastdyn.kernels.methods.taylor.steps.kernel")(order, width), SERIES


def series_in_lanes(order, width):
    """The loop of Taylor on vectors with a trajectory in each lane."""
    return _named("fastdyn.kernels.methods.taylor.lanes.kernel")(order, width), SERIES_IN_LANES


def inlining(name, splits, function, n):
    """The loop of a method with one function inlined, on tuples of n numbers."""
    method = BY_NAME[name].code
    user = function.build()
    form = (0.0,) * n
    if isinstance(user, tuple):
        velocity, force = (part_inlined(*one) for one in zip(user, (VELOCITY, FORCE), strict=True))
        if splits:
            return method.separable(velocity)(force, form), ADVANCE
        return method.kernel(both_inlined(velocity, force), form), ADVANCE
    return _around(method, user, form)


def without_function(name, n):
    """The loop of a method for one function, which LLVM links into the loop later."""
    return _around(BY_NAME[name].code, linked_later(unlinked.FUNCTION), (0.0,) * n)


def _around(method, user, form):
    @njit(**INTERNAL)
    def rhs(t, y, block, out):
        return inlined(user, t, y, block)

    return method.kernel(rhs, form), ADVANCE


def stages(name, n):
    """The loop of an implicit method for one function, which LLVM links into the loop later.

    The function evaluates all stages at once, on n vectors.
    """
    s, batched = BY_NAME[name].code.batched
    function = named(unlinked.FUNCTION, n)
    return batched(right_hand_side(function), Form(n, s, exact=True)), ADVANCE
