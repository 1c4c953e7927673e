"""One iteration of an implicit step: stages from increments, increments from stages."""

from ...calls.block import RAISED_WORD
from ...jit.options import INLINED, njit
from ...state.elementwise import halves
from ...state.layout import Form
from ...state.record import STAGE, K
from ...state.rows import fetch, keep_vector, numbers_of, slot, vector_at
from .stages import Matrix, first_row, keep_increments, stage_value, with_ends

INCREMENTS = K  # the first row of the L_j


def rows(s):
    """The first rows of compensation, stages, changes (two rows) and slope: see `INCREMENTS`."""
    return K + s, K + s + 1, K + 2 * s + 1, K + 2 * s + 3


def outer_weights(s, b):
    """``weight(h, i)``: h b_i, with the two outermost weights such that the sum is exactly h."""
    half = s // 2

    @njit(**INLINED)
    def weight(h, i):
        if 0 < i < s - 1:
            return h * b[i]
        inner = 0.0
        for j in range(1, half):
            inner += h * b[j]
        return 0.5 * h - inner

    return weight


def all_weights(b, weight):
    """``weights(h)``: the vector of all h b_i."""
    row = Matrix([b])

    @njit(**INLINED)
    def weights(h):
        return with_ends(h * first_row(row), weight(h, 0))

    return weights


def make_sweep(nystrom, s, weights, refined):
    """``sweep(work, h, count)``: new stages; returns the largest patience, see `collocation.py`."""
    _, STAGES, _, _ = rows(s)
    stages = Form(1, s, exact=True)

    @njit(**INLINED)
    def sweep(work, h, count):
        n = work.shape[1]
        numbers = numbers_of(work)
        patience = 0
        m = n // 2 if nystrom else 0
        for k in range(m, n):
            patience = max(patience, refined(work, k, count))
        if nystrom:
            for k in range(m):  # positions follow velocities
                velocity = vector_at(stages, numbers, STAGES * n + (m + k) * s)
                keep_vector(stages, numbers, INCREMENTS * n + k * s, weights(h) * velocity)
                patience = max(patience, refined(work, k, count))
        return patience

    return sweep


def make_evaluate(batched, nystrom, s, c, weight, weights):
    """``evaluate(rhs, t, h, form, work, block)``: all increments; returns the evaluations."""
    _, STAGES, _, SLOPE = rows(s)
    nodes = Matrix([c])

    @njit(**INLINED)
    def equation_part(value):
        """The part of a state that the equations take or return: positions alone if `nystrom`."""
        return halves(value)[0] if nystrom else value

    @njit(**INLINED)
    def evaluate(rhs, t, h, form, work, block):
        n = work.shape[1]
        numbers = numbers_of(work)
        found = INCREMENTS * n + (n // 2 * s if nystrom else 0)  # positions come first
        if batched:
            f = rhs(t + first_row(nodes) * h, fetch(form, work, STAGES), block, None)
            keep_increments(f, weights(h), numbers, found, s)
            return s
        part = equation_part(form)
        place = equation_part(slot(form, work, STAGE))
        target = equation_part(slot(form, work, SLOPE))
        for i in range(s):
            u = stage_value(part, place, numbers, STAGES * n + i, s)
            f = rhs(t + c[i] * h, u, block, target)
            keep_increments(f, weight(h, i), numbers, found + i, s)
            if block[RAISED_WORD] != 0:
                return i + 1
        return s

    return evaluate
