"""The loop for embedded pairs: any step, any controller, any storage of the state."""

from ..calls.block import RAISED_WORD
from ..jit.options import INTERNAL, njit
from ..state.elementwise import assign
from ..state.record import ATOL, FINISHED, RAISED, RTOL, RUNNING, STEP_TOO_SMALL, Y_OLD, K, Y
from ..state.rows import fetch, keep, slot
from ..vector.scalar_or_vector import rare


def kernel(step, control, exponent, fsal_stage, rhs, form):
    """The loop around `rhs`.

    Parameters
    ----------
    step : function
        ``step(rhs, t, y, h, k1, block, form, work, rtol, atol)`` returns the new value, the
        tuple of stages, and the norm of the error estimate.
    control : Controller
    exponent : float
        -1 / (order of the error estimate + 1).
    fsal_stage : int
        The stage that is the derivative at the end of a step, and the first of the next.
    rhs : function
        ``rhs(t, y, block, out)``, the derivative as a value of the state.
    form : None or tuple of n floats
        How values are stored; see `rows.fetch`.

    Returns
    -------
    function
        ``loop(state, work, block, n_steps)`` takes at most `n_steps` accepted steps, no further
        than the step that reaches `t_stop` or is shorter than `h_short`, and returns RUNNING,
        FINISHED, STEP_TOO_SMALL or RAISED.  For the arrays see `state/record.py` and
        `calls/user_function.py`.
    """

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps):
        s = state[0]
        direction = s.direction
        t_end = s.t_end
        t_stop = s.t_stop
        h_max = s.h_max
        t = s.t
        t_old = s.t_old
        h = s.h
        error = s.error
        h_short = s.h_short
        rtol = fetch(form, work, RTOL)
        atol = fetch(form, work, ATOL)
        y = fetch(form, work, Y)
        k_last = fetch(form, work, K + fsal_stage)
        status = RUNNING
        taken = 0
        refused = 0
        if direction * (t - t_end) >= 0.0:
            return FINISHED
        while taken < n_steps:
            h_min = control.smallest(t, direction)
            h = h_max if h > h_max else h_min if h < h_min else h
            y_old = assign(slot(form, work, Y_OLD), y)
            k1 = assign(slot(form, work, K), k_last)
            rejections = 0
            while True:
                if h < h_min:  # rejected once more, or h_max is below the spacing of t
                    status = STEP_TOO_SMALL
                    break
                wanted = h
                t_new = control.aim(t, h, t_end, direction)
                h = abs(t_new - t)
                y, k, error = step(rhs, t, y_old, t_new - t, k1, block, form, work, rtol, atol)
                if block[RAISED_WORD] != 0:
                    status = RAISED
                    break
                if error < 1.0:
                    break
                h = control.shrink(h, error, exponent, rejections, h_min)
                rejections += 1
            refused += rejections
            if status != RUNNING:
                y = assign(slot(form, work, Y), y_old)
                keep(work, Y, (y, y_old))
                break
            h = control.grow(h, error, exponent, rejections)
            if rare(t_new == t_end and h < wanted):  # shortened to reach t_end, not for its error
                h = wanted
            t_old, t, k_last = t, t_new, k[fsal_stage]
            taken += 1
            ends = direction * (t - t_stop) >= 0.0 or abs(t - t_old) < h_short
            if t == t_end:
                status = FINISHED
            if status == FINISHED or taken == n_steps or ends:
                keep(work, Y, (y, y_old))
                keep(work, K, k)
                break
        s.t, s.t_old, s.h, s.error = t, t_old, h, error
        s.n_accepted += taken
        s.n_rejected += refused
        return status

    return loop
