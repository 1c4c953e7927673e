"""The record that evolves, the rows of the work array, and the status codes.

A solve in progress is three arrays: `state` (one record of STATE), `work` (rows of n numbers)
and `block` (the data of a compiled function, see `calls/user_function.py`).  A copy of the three
arrays is a checkpoint: every kernel reads the arrays when it starts, and leaves them complete when
it returns.
"""

from typing import Any, NamedTuple

import numpy as np

STATE = np.dtype(
    [
        ("t", "f8"),  # time reached
        ("t_old", "f8"),  # time before the last accepted step
        ("t_end", "f8"),
        ("t_stop", "f8"),  # the kernel returns after the step that reaches this time
        ("t_start", "f8"),
        ("direction", "f8"),  # +1 or -1
        ("h", "f8"),  # size of the next step to try, without sign
        ("h_max", "f8"),
        ("h_first", "f8"),  # size of the first step, also after a jump; 0: the method chooses
        ("error", "f8"),  # norm of the last error estimate; accepted below 1
        ("n_accepted", "i8"),
        ("n_rejected", "i8"),
        ("n_extra", "i8"),  # evaluations outside the steps: start, dense output
        # Fields of methods that factorise matrices, or use more than the last step:
        # Size of the step before; 0 if the method has no step before.  For Taylor, the size below
        # which steps try the tangent; 0: any.
        ("h_old", "f8"),
        ("order", "i8"),  # order of the next step; 0 where the method begins, or begins anew
        # Steps since size or order changed; for Taylor, steps at a jump; for LSODA, order of the
        # last step.
        ("n_equal", "i8"),
        ("factorised", "i8"),  # whether the factors of the last step hold for the next
        ("current", "i8"),  # whether the Jacobian belongs to the present state
        ("lower", "i8"),  # diagonals of the Jacobian below the main diagonal, and above
        ("upper", "i8"),
        ("pairs", "i8"),  # whether two components are a complex number
        ("n_jacobians", "i8"),
        ("n_factorised", "i8"),
        # Options of LSODA from the user:
        ("h_least", "f8"),  # shortest step
        ("lband", "i8"),  # diagonals of the Jacobian below the main diagonal, and above; -1: all
        ("uband", "i8"),
        ("highest_adams", "i8"),  # highest order of each family; 0: the family is not taken
        ("highest_bdf", "i8"),
        ("passes_end", "i8"),  # whether steps may pass t_end, as odeint's, up to t_limit
        ("t_limit", "f8"),  # infinite, of either sign: no limit
        # Data that LSODA keeps from step to step:
        ("rescale", "f8"),  # factor of the step size to which the Nordsieck array must be changed
        ("growth", "f8"),  # the largest factor by which the size may grow
        ("l0", "f8"),  # first coefficient of the formula
        ("drift", "f8"),  # h l0 over the h l0 of the factors
        ("rate", "f8"),  # rate of convergence
        ("lipschitz", "f8"),  # estimates of the Lipschitz constant: in use, since the last reset
        ("lipschitz_now", "f8"),
        ("jacobian_norm", "f8"),
        ("t_switched", "f8"),  # last time at which the family changed
        ("h_standing", "f8"),  # size from which `n_standing` counts
        ("stiff", "i8"),  # whether the next step is a step of BDF, and whether the last step was
        ("was_stiff", "i8"),
        ("limited", "i8"),  # whether stability bounds the step of Adams' formula
        ("wait", "i8"),  # steps until order and size, and until the family, may change
        ("wait_family", "i8"),
        ("age", "i8"),  # number of steps with the present factors
        # For LSODA, trials that are too short to change the time, at one size; for Radau and BDF,
        # steps whose change `fun` does not make, see `beyond` in stepping/implicit.py.
        ("n_standing", "i8"),
        # For components that must not be negative:
        ("cut", "f8"),  # sum of the corrections from below 0 to 0, in units of atol
        # For the function of `on_event` that was called last:
        ("acted", "i8"),  # the index of the event: event functions first, then schedules
        ("component", "i8"),  # the component of the returned state that is refused
        # For snapshots, see state/snapshots.py:
        ("h_short", "f8"),  # the kernel returns after a step that is shorter
    ]
)


class Solve(NamedTuple):
    """A solve in progress, as kernels take it."""

    state: Any
    work: Any
    block: Any


# Rows of `work`.  A method's stages follow from row K on.
Y = 0
Y_OLD = 1
STAGE = 2
RTOL = 3
ATOL = 4
K = 5

# What a kernel returns.
RUNNING = 0  # the step budget is used up; call again
FINISHED = 1  # t == t_end
FULL = 2  # an output array is full; the caller makes room and calls again
EVENT = 3  # a terminal event occurred
STEP_TOO_SMALL = 4
NON_FINITE = 5  # the first derivative, or the state after a constant step, is not finite
NOT_CONVERGED = 7  # the iteration of an implicit step did not converge
RAISED = 6  # the user's function raised; the exception waits in Python
BAD_STATE = 8  # the initial state is not finite
BAD_JUMP = 9  # the state after an event is not finite
ZENO = 10  # an event occurs infinitely often in a finite time
BAD_JACOBIAN = 11  # the Jacobian is not finite
SINGULAR = 12  # the matrix of a linearly implicit step is singular, however short the step
FAILED_AGAIN = 13  # a step of LSODA failed ten times, or at the shortest size
NO_TOLERANCE = 14  # atol and a component of the state are zero
BORDER = 15  # the solution leaves the domain of the equations
OUTSIDE = 16  # the state after an event lies outside of the domain
NEGATIVE = 17  # a component of the state after an event is negative, and must not be
MEETING = 18  # two planets meet

# Status codes of the loops above the steps.
STEP_LIMIT = 100
INTERRUPTED = 101
STOPPED = 102
