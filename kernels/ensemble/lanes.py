"""The loops of `adaptive` and `fixed` on vectors: a trajectory in each lane, each with its own
time and step.

Lanes never wait for each other and never mix.  A loop returns to the scheduler (`serve`) as soon as
a lane has reached its stop time or cannot go on.  `serve` then puts another trajectory into each
lane whose trajectory is finished.
"""

import numpy as np

from ..jit.options import INLINED, INTERNAL, njit
from ..output.extrema import turning
from ..state.elementwise import apply
from ..state.lane_fields import (
    ACCEPTED,
    ERROR,
    EVALUATIONS,
    LEFT,
    LIMIT,
    LIVE,
    NOTHING,
    REJECTED,
    STATUS,
    T_END,
    T_OLD,
    T_STOP,
    TRIES,
    H,
    T,
)
from ..state.record import ATOL, FINISHED, RTOL, RUNNING, STEP_TOO_SMALL, K, Y
from ..state.reduce import add, reduce_components
from ..state.rows import fetch, keep, keep_vector, numbers_of, vector_at
from ..stepping.fixed import LANDED, add_size
from ..vector.scalar_or_vector import any_lane, select


@njit(**INLINED)
def _chosen(mask, a, b):
    return (select(mask, a, b),)


@njit(**INLINED)
def choose(mask, a, b):
    """The value a in the lanes where the mask is true, b in the others."""
    return apply(_chosen, (None,), (mask,), (a, b))[0]


@njit(**INLINED)
def field(form, lanes, row):
    """Row `row` of `lanes` as a vector."""
    return vector_at(form, numbers_of(lanes), row * lanes.shape[1])


@njit(**INLINED)
def leave(form, lanes, row, value):
    """Store a vector in row `row` of `lanes`."""
    keep_vector(form, numbers_of(lanes), row * lanes.shape[1], value)


@njit(**INLINED)
def add_evaluations(form, lanes, counted, accepted, rejected):
    """Count the evaluations of the steps since ACCEPTED and REJECTED were stored."""
    of_step, behind = counted
    more = accepted - field(form, lanes, ACCEPTED)
    others = rejected - field(form, lanes, REJECTED)
    total = field(form, lanes, EVALUATIONS) + of_step * (more + others) + behind * more
    leave(form, lanes, EVALUATIONS, total)


@njit(**INLINED)
def leave_steps(form, lanes, t, t_old, h, error):
    """Store where the last step ended and began, the size of the next, and the error."""
    leave(form, lanes, T, t)
    leave(form, lanes, T_OLD, t_old)
    leave(form, lanes, H, h)
    leave(form, lanes, ERROR, error)


@njit(**INLINED)
def leave_counts(form, lanes, accepted, rejected, tries):
    leave(form, lanes, ACCEPTED, accepted)
    leave(form, lanes, REJECTED, rejected)
    leave(form, lanes, TRIES, tries)


def adaptive(
    step, control, exponent, fsal_stage, rhs, form, extrema, watched, accumulated, counted=None
):
    """The loop of a method with adaptive steps around `rhs`, on vectors.

    Parameters
    ----------
    step, control, exponent, fsal_stage
        See `stepping.adaptive.kernel`.
    form : Form
    extrema : None or anything else
        Whether to return to the scheduler when a step may contain a new maximum or minimum of a
        component.  The last two rows of `work` hold the extrema so far.
    watched : None or function
        ``watched(form, at, at_new, ok, block, lanes)``: the lanes in which an event may have
        occurred.  `at` and `at_new` are the time, the state and the slope at both ends of the step.
    accumulated : None or function
        ``accumulated(form, t, y, on, block, lanes)`` updates the folds with the state in the lanes
        that go on.  The scheduler updates the folds of the other lanes.
    counted : None or (int, int)
        For a method that counts its evaluations itself: the evaluations of a step, and the
        evaluations after an accepted step.  The step of such a method returns a negative error in
        the lanes that it leaves to the kernel for one trajectory.  Lanes whose error is not finite
        are left to this kernel, too.

    Returns
    -------
    function
        ``loop(state, lanes, work, block, n_steps)`` tries at most `n_steps` steps in each lane and
        returns the number of steps tried.  `state` is a STATE record with the fields that all lanes
        share; `lanes`, (N_FIELDS, width), and `work`, (rows, n * width), have the data of each
        lane.  Row STATUS tells which lanes need the scheduler: FINISHED, RUNNING (T_STOP or LIMIT
        was reached), STEP_TOO_SMALL or LEFT.
    """

    @njit(**INTERNAL)
    def loop(state, lanes, work, block, n_steps):
        direction, h_max = state[0].direction, state[0].h_max
        t = field(form, lanes, T)
        t_end, t_stop = field(form, lanes, T_END), field(form, lanes, T_STOP)
        h, live = field(form, lanes, H), field(form, lanes, LIVE) > 0.0
        limit = field(form, lanes, LIMIT)
        accepted, rejected = field(form, lanes, ACCEPTED), field(form, lanes, REJECTED)
        tries = field(form, lanes, TRIES)
        rtol, atol = fetch(form, work, RTOL), fetch(form, work, ATOL)
        y, k_last = fetch(form, work, Y), fetch(form, work, K + fsal_stage)
        if extrema is not None:
            tops, lows = fetch(form, work, len(work) - 2), fetch(form, work, len(work) - 1)
        taken = 0
        while True:
            taken += 1
            h_min = control.smallest(t, direction)
            wanted = select(h > h_max, h_max, select(h < h_min, h_min, h))
            t_new = control.aim(t, wanted, t_end, direction)
            size = t_new - t
            y_new, k, error = step(rhs, t, y, size, k_last, block, form, work, rtol, atol)
            stuck = wanted < h_min  # h_max is below the spacing of t
            # A lane with NaN is left to the kernel for one trajectory, because only that kernel
            # finds out whether the function raises.
            left = ~((error >= 0.0) & (error < np.inf)) & ~stuck
            not_tried = stuck | left
            ok = (error < 1.0) & ~not_tried
            size = abs(size)
            longer = control.grow(size, error, exponent, tries)
            shortened = (t_new == t_end) & (longer < wanted)  # to end at t_end, not for the error
            shorter = control.shrink(size, error, exponent, tries, h_min)
            again = select(not_tried, h, shorter)
            h = select(ok, select(shortened, wanted, longer), again)
            accepted = accepted + select(ok, 1.0, 0.0)
            rejected = rejected + select(ok | not_tried, 0.0, 1.0)
            tries = select(ok, 0.0, tries + 1.0)
            stopped = ok & ((direction * (t_new - t_stop) >= 0.0) | (accepted >= limit))
            failed = stuck | (~ok & (h == 0.0))
            hand_back = live & (stopped | failed | not_tried)
            if extrema is not None:
                hand_back = hand_back | (
                    live & ok & turning(t_new - t, y, y_new, k_last, k[fsal_stage], tops, lows)
                )
            if watched is not None:
                both = (t, y, k_last), (t_new, y_new, k[fsal_stage])
                hand_back = hand_back | (live & watched(form, *both, ok, block, lanes))
            if accumulated is not None:
                accumulated(form, t_new, y_new, ok & ~hand_back, block, lanes)
            t_old, y_old = t, y
            t, y = select(ok, t_new, t), choose(ok, y_new, y)
            k_new = choose(ok, k[fsal_stage], k_last)
            if taken >= n_steps or any_lane(hand_back):
                break
            k_last = k_new
        status = select(failed, float(STEP_TOO_SMALL), select(t == t_end, float(FINISHED), 0.0))
        status = select(left, float(LEFT), status)
        if counted is not None:
            add_evaluations(form, lanes, counted, accepted, rejected)
        leave(form, lanes, STATUS, select(hand_back, status, float(NOTHING)))
        leave_steps(form, lanes, t, t_old, h, error)
        leave_counts(form, lanes, accepted, rejected, tries)
        keep(work, K, k)
        keep(work, Y, (y, y_old))
        keep(work, K + fsal_stage, (k_new,))
        return taken

    return loop


def fixed(step, fsal_stage, compensation_stage, rhs, form, extrema, watched, accumulated):
    """The loop of a method with constant steps, on vectors: see `adaptive`, `fixed.kernel`."""

    @njit(**INTERNAL)
    def loop(state, lanes, work, block, n_steps):
        s = state[0]
        direction = s.direction
        t_start = s.t_start
        t = field(form, lanes, T)
        t_end = field(form, lanes, T_END)
        t_stop = field(form, lanes, T_STOP)
        live = field(form, lanes, LIVE) > 0.0
        limit = field(form, lanes, LIMIT)
        size = field(form, lanes, H)
        accepted = field(form, lanes, ACCEPTED)
        h = direction * size
        y = fetch(form, work, Y)
        k_last = fetch(form, work, K + fsal_stage)
        compensation = fetch(form, work, K + compensation_stage)
        if extrema is not None:
            tops = fetch(form, work, len(work) - 2)
            lows = fetch(form, work, len(work) - 1)
        taken = 0
        while True:
            taken += 1
            y_new, k = step(rhs, t, y, h, k_last, compensation, block, form, work)
            ok = reduce_components(add_size, add, 0.0, (y_new,)) < np.inf
            accepted = accepted + select(ok, 1.0, 0.0)
            t_new = t_start + accepted * h
            t_new = select(abs(t_new - t_end) <= LANDED * size, t_end, t_new)
            reached = (direction * (t_new - t_stop) >= 0.0) | (direction * (t_new - t_end) >= 0.0)
            hand_back = live & (~ok | reached | (accepted >= limit))
            if extrema is not None:
                hand_back = hand_back | (
                    live & ok & turning(h, y, y_new, k_last, k[fsal_stage], tops, lows)
                )
            if watched is not None:
                both = (t, y, k_last), (t_new, y_new, k[fsal_stage])
                hand_back = hand_back | (live & watched(form, *both, ok, block, lanes))
            if accumulated is not None:
                accumulated(form, t_new, y_new, ok & ~hand_back, block, lanes)
            t_old = t
            y_old = y
            t = select(ok, t_new, t)
            y = choose(ok, y_new, y)
            k_new = choose(ok, k[fsal_stage], k_last)
            compensation_new = choose(ok, k[compensation_stage], compensation)
            if taken >= n_steps or any_lane(hand_back):
                break
            k_last = k_new
            compensation = compensation_new
        over = select(direction * (t - t_end) >= 0.0, float(FINISHED), float(RUNNING))
        leave(
            form, lanes, STATUS,
            select(hand_back, select(ok, over, float(LEFT)), float(NOTHING)),
        )  # fmt: skip
        leave(form, lanes, T, t)
        leave(form, lanes, T_OLD, t_old)
        leave(form, lanes, ACCEPTED, accepted)
        keep(work, K, k)
        keep(work, Y, (y, y_old))
        keep(work, K + fsal_stage, (k_new,))
        keep(work, K + compensation_stage, (compensation_new,))
        return taken

    return loop
