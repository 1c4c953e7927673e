"""One iteration of an implicit step: stages from increments, increments from stages."""

from ..calls.user_function import RAISED as RAISED_WORD
from ..jit_options import FUSED, njit
from ..state.elementwise import halves
from ..state.record import STAGE, K
from ..state.rows import fetch, slot
from .stages import (
    follow,
    keep_increment,
    keep_increments,
    stage_times,
    stage_value,
)

INCREMENTS = K  # the first row of the L_j


def rows(s):
    """The rows behind the increments: compensation, stages, changes (two), slope."""
    return K + s, K + s + 1, K + 2 * s + 1, K + 2 * s + 3


def outer_weights(s, b):
    """``weight(h, i)``: h b_i, the outermost two such that all add up to h."""
    half = s // 2

    @njit(**FUSED)
    def weight(h, i):
        if 0 < i < s - 1:
            return h * b[i]
        inner = 0.0
        for j in range(1, half):
            inner += h * b[j]
        return 0.5 * h - inner

    return weight


def make_sweep(nystrom, s, weights, weight, refined):
    """``sweep(work, h, count)``: new stages from the increments; the longest patience needed."""
    _, STAGES, _, _ = rows(s)
    if nystrom:

        @njit(**FUSED)
        def sweep(work, h, count):
            n = work.shape[1]
            m = n // 2
            patience = 0
            for k in range(m, n):
                patience = max(patience, refined(work, k, count))
            for k in range(m):
                follow(weights, work, INCREMENTS, STAGES, k, k + m, h, weight(h, 0))
                patience = max(patience, refined(work, k, count))
            return patience

    else:

        @njit(**FUSED)
        def sweep(work, h, count):
            patience = 0
            for k in range(work.shape[1]):
                patience = max(patience, refined(work, k, count))
            return patience

    return sweep


def make_evaluate(nystrom, s, mu, c, weight):
    """``evaluate(rhs, t, h, i, form, work, block)``: the increments of stage i from its stage."""
    _, STAGES, _, SLOPE = rows(s)
    if nystrom:

        @njit(**FUSED)
        def evaluate(rhs, t, h, i, form, work, block):
            part, _ = halves(form)
            place, _ = halves(slot(form, work, STAGE))
            target, _ = halves(slot(form, work, SLOPE))
            u = stage_value(part, place, work, STAGES, mu, i)
            f = rhs(t + c[i] * h, u, block, target)
            behind = work.shape[1] // 2 * s  # the velocities' come after the positions'
            keep_increment(f, work, INCREMENTS, mu, i + behind, weight(h, i))

    else:

        @njit(**FUSED)
        def evaluate(rhs, t, h, i, form, work, block):
            u = stage_value(form, slot(form, work, STAGE), work, STAGES, mu, i)
            f = rhs(t + c[i] * h, u, block, slot(form, work, SLOPE))
            keep_increment(f, work, INCREMENTS, mu, i, weight(h, i))

    return evaluate


def make_evaluate_all(batched, nystrom, s, nodes, weights, weight, evaluate):
    """``evaluate_all(rhs, t, h, form, work, block)``: the increments of all stages; how many."""
    _, STAGES, _, _ = rows(s)
    if batched:

        @njit(**FUSED)
        def evaluate_all(rhs, t, h, form, work, block):
            behind = work.shape[1] // 2 if nystrom else 0
            f = rhs(stage_times(nodes, t, h), fetch(form, work, STAGES), block, None)
            keep_increments(weights, work, INCREMENTS, behind, f, h, weight(h, 0))
            return s

    else:

        @njit(**FUSED)
        def evaluate_all(rhs, t, h, form, work, block):
            for i in range(s):
                evaluate(rhs, t, h, i, form, work, block)
                if block[RAISED_WORD] != 0:
                    return i + 1
            return s

    return evaluate_all
