"""The kernels for Numba, each a dispatcher and its signature.

This file imports Numba.  A solve imports this file only if a kernel is not on disk yet.
"""

from numba import types

from fastdyn.code_store import unlinked
from fastdyn.kernels.algebra import consistent_states
from fastdyn.kernels.algebra.complex_matrices import (
    other_complex_factors,
    other_complex_solution,
)
from fastdyn.kernels.algebra.matrices import other_factors, other_solution
from fastdyn.kernels.algebra.padded.factors import factors
from fastdyn.kernels.algebra.padded.solution import solution
from fastdyn.kernels.calls.block import FORCE, VELOCITY
from fastdyn.kernels.calls.user_function import FORM, by_pointer, inlined, linked_later
from fastdyn.kernels.calls.velocity_force import (
    both_by_pointer,
    both_inlined,
    force_by_pointer,
    part_inlined,
    velocity_by_pointer,
)
from fastdyn.kernels.ensemble import scheduler
from fastdyn.kernels.ensemble.watched import already
from fastdyn.kernels.jit.options import INTERNAL, njit
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods.taylor import lanes as taylor_lanes
from fastdyn.kernels.methods.taylor import steps as taylor_steps
from fastdyn.kernels.methods.wisdom_holman import steps as wisdom_holman
from fastdyn.kernels.output.between_steps import watch, watch_events, watch_plain
from fastdyn.kernels.output.dense_output import interpolant
from fastdyn.kernels.output.events import open_events
from fastdyn.kernels.output.invariants import open_survey, survey
from fastdyn.kernels.output.series_roots.all_roots import find_all
from fastdyn.kernels.output.whole_solves import launch, solve_many, whole_solve
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.state.record import RUNNING
from fastdyn.kernels.stepping import (
    backward,
    backward_collocation,
    backward_rosenbrock,
    backward_splitting,
    backward_whole,
    collocation,
    first_step,
)
from fastdyn.kernels.stepping.jacobian import other_jacobian

from .signatures import (
    ADVANCE,
    DENSE_ROWS,
    EVALUATE,
    FACTORS,
    FIND,
    INTERPOLANT,
    LAUNCH,
    MANY,
    NEWTON,
    OPEN,
    OPEN_SURVEY,
    OTHER_COMPLEX_FACTORS,
    OTHER_FACTORS,
    OTHER_JACOBIAN,
    OTHER_SOLUTION,
    REPLAY,
    REPLAY_OF_COLLOCATION,
    REPLAY_OF_KICKS,
    REPLAY_OF_ROSENBROCK,
    RESIDUALS,
    SERIES,
    SERIES_IN_LANES,
    SOLUTION,
    START,
    SURVEYING,
    SWEEP,
    SWEEP_OF_COLLOCATION,
    SWEEP_OF_KICKS,
    SWEEP_OF_ROSENBROCK,
    SWEEP_WHOLE,
    WATCH,
    WHOLE_SOLVE,
    kernel_of,
)
from .vector_rhs import named, right_hand_side


@njit(**INTERNAL)
def _evaluate(block, t, y, out):
    by_pointer(t, y, block, out)
    return RUNNING


FUNCTION = types.none(*FORM)  # the form of a user's function
FOR_ALL = {  # kernels that serve all methods and functions
    "evaluate": (_evaluate, EVALUATE),  # one call of a function
    "factors": (factors, FACTORS),  # of a system of equations inside a function
    "solution": (solution, SOLUTION),
    "newton": (collocation.newton, NEWTON),
    "residuals": (collocation.rms_residuals, RESIDUALS),
    "watch": (watch, WATCH),
    "watch events": (watch_events, WATCH),  # for solves with events and nothing else
    "watch plain": (watch_plain, WATCH),  # for solves without events, projection, breakpoints
    "launch": (launch, LAUNCH),
    "interpolant": (interpolant, INTERPOLANT),
    "many": (solve_many, MANY),
    "whole solve": (whole_solve, WHOLE_SOLVE),
    "events": (open_events, OPEN),
    "all roots": (find_all, FIND),  # the events of a step, by series
    "open survey": (open_survey, OPEN_SURVEY),
    "survey": (survey, SURVEYING),
    "already": (already, ADVANCE),
    "wisdom holman": (wisdom_holman.advance, ADVANCE),
    "sweep": (backward.sweep, SWEEP),
    "replay": (backward.replay, REPLAY),
    "sweep whole": (backward_whole.sweep_whole, SWEEP_WHOLE),
    "sweep of kicks": (backward_splitting.sweep, SWEEP_OF_KICKS),
    "replay of kicks": (backward_splitting.replay, REPLAY_OF_KICKS),
    "sweep of rosenbrock": (backward_rosenbrock.sweep, SWEEP_OF_ROSENBROCK),
    "replay of rosenbrock": (backward_rosenbrock.replay, REPLAY_OF_ROSENBROCK),
    "sweep of collocation": (backward_collocation.sweep, SWEEP_OF_COLLOCATION),
    "replay of collocation": (backward_collocation.replay, REPLAY_OF_COLLOCATION),
    "other jacobian": (other_jacobian, OTHER_JACOBIAN),
    "other factors": (other_factors, OTHER_FACTORS),
    "other solution": (other_solution, OTHER_SOLUTION),
    "other complex factors": (other_complex_factors, OTHER_COMPLEX_FACTORS),
    "other complex solution": (other_complex_solution, OTHER_SOLUTION),
    "both of a pair": (both_by_pointer, FUNCTION),
} | {
    f"pencil {name}": (getattr(consistent_states, name), FUNCTION)
    for name in ("rates", "change", "settle", "act")
}


def serve(*sample):
    """The kernel in which a worker of an ensemble serves its lanes, for arguments like `sample`."""
    return scheduler.serve, kernel_of(*sample)


def start(method, splits):
    """The start of a method; `splits` tells whether a pair's functions are called separately."""
    return first_step.plain if splits else method.code.start, START


def dense_rows(method, splits):
    """The interpolant of a method."""
    rows = method.code.rows_of_pair() if splits else method.code.dense_rows
    rhs = force_by_pointer if splits else by_pointer

    @njit(**INTERNAL)
    def kernel(t, h, work, block, d):
        return rows(rhs, t, h, work, block, d)

    return kernel, DENSE_ROWS


def shared(method, splits):
    """The loop of a method for any function, or for the velocity and the force of a pair."""
    if splits:
        return method.code.separable(velocity_by_pointer)(force_by_pointer, None), ADVANCE
    return method.code.kernel(by_pointer, None), ADVANCE


def series(order, width):
    """The loop of Taylor around the series of any function, in vectors of `width` lanes."""
    return taylor_steps.kernel(order, width), SERIES


def series_in_lanes(order, width):
    """The loop of Taylor on vectors with a trajectory in each lane."""
    return taylor_lanes.kernel(order, width), SERIES_IN_LANES


def inlining(name, splits, function, n):
    """The loop of a method with one function inlined, on tuples of n numbers."""
    method = BY_NAME[name].code
    user, form = function.build(), (0.0,) * n
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
