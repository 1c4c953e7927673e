"""The equations of a step of LSODA, solved by fixed-point iteration or by Newton's method.

K. Radhakrishnan and A. C. Hindmarsh, NASA RP-1327 (1993), sections 2.3 and 2.4: iterations, their
test, the Jacobian and its renewal.  L. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983): L, an
estimate of the Lipschitz constant, from the rates of convergence.
"""

import numpy as np

from ...algebra.factorise import bandwidths
from ...algebra.matrices import factorise_sum, matrix_at, matrix_rows, solve_sum
from ...calls.block import FIRST, GROUPS, JACOBIAN, N_ENTRIES
from ...calls.user_function import words_at
from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import BAD_JACOBIAN, RAISED, RUNNING
from ...state.rows import copy_row
from ...stepping.differences import evaluate_row
from ...stepping.jacobian import entries_at, evaluate_jacobian, is_constant
from .past import CHANGE, FACTOR, FOUND, PIVOTS, RATE, TRIAL, WEIGHT, J, Z, norm
from .table import CORRECTION, SAME

EPS = float(np.finfo(float).eps)
ITERATIONS = 3  # as in ODEPACK
SLOWEST = 1024.0  # largest rate of convergence that is used


@njit(**INLINED)
def _factors(work, block):
    """The first row of the factors, behind the Jacobian."""
    return J + matrix_rows(block, work.shape[1])


@njit(**INTERNAL)
def _increment(work, j, noise):
    """The displacement of component j; of one with an infinite tolerance by its size alone."""
    if work[WEIGHT, j] == 0.0:
        return np.sqrt(EPS) * max(abs(work[Z, j]), 1.0)
    return max(np.sqrt(EPS) * abs(work[Z, j]), noise / work[WEIGHT, j])


@njit(**INTERNAL)
def _difference(rhs, s, t, work, block, h):
    """The Jacobian at the state in row TRIAL by forward differences; False if the function raised.

    Columns without a common row share an evaluation: RP-1327, equations (2.43) to (2.45).
    """
    n = work.shape[1]
    banded = s.lband >= 0
    noise = 1000.0 * abs(h) * EPS * n * norm(work, RATE)
    if noise == 0.0:
        noise = 1.0
    stride = min(n, s.lband + s.uband + 1) if banded else n
    for first in range(stride):
        for j in range(first, n, stride):
            work[TRIAL, j] = work[Z, j] + _increment(work, j, noise)
        s.n_extra += 1
        if not evaluate_row(rhs, t, work, TRIAL, FOUND, block):
            return False
        for j in range(first, n, stride):
            work[TRIAL, j] = work[Z, j]
            step = _increment(work, j, noise)
            begin, end = (max(0, j - s.uband), min(n, j + s.lband + 1)) if banded else (0, n)
            for i in range(begin, end):
                work[J + j, i] = (work[FOUND, i] - work[RATE, i]) / step
    return True


@njit(**INTERNAL)
def _jacobian(rhs, s, t, work, block, h):
    """The Jacobian at the predicted state, within its band; RUNNING, RAISED or BAD_JACOBIAN."""
    n = work.shape[1]
    banded = s.lband >= 0
    s.n_jacobians += not is_constant(block)
    if block[JACOBIAN] != 0:
        status = evaluate_jacobian(s, t, work, Z, RATE, block, FACTOR, J)
        if status == RUNNING and banded:
            _cut(s, work)
        return status
    if not _difference(rhs, s, t, work, block, h):
        return RAISED
    s.lower, s.upper = (min(s.lband, n - 1), min(s.uband, n - 1)) if banded else (n - 1, n - 1)
    for j in range(n):
        for i in range(max(0, j - s.upper), min(n, j + s.lower + 1)):
            if not np.isfinite(work[J + j, i]):
                return BAD_JACOBIAN
    if not banded:
        s.lower, s.upper = bandwidths(matrix_at(work, block, J), n)
    return RUNNING


@njit(**INTERNAL)
def _cut(s, work):
    """Set elements outside of the user's band to zero."""
    n = work.shape[1]
    for j in range(n):
        for i in range(max(0, j - s.upper), min(n, j + s.lower + 1)):
            if not -s.uband <= i - j <= s.lband:
                work[J + j, i] = 0.0
    s.lower, s.upper = min(s.lower, s.lband), min(s.upper, s.uband)


@njit(**INTERNAL)
def _sum_rows(s, work, block):
    """For each row of the Jacobian, the sum of |element| / weight of its column.

    The sum runs over the entries of a sparse Jacobian, or over the band, without the columns of
    components with an infinite tolerance, which the norm does not measure.
    """
    n = work.shape[1]
    given = block[JACOBIAN]
    for i in range(n):
        work[FOUND, i] = 0.0
    if given != 0 and words_at(given)[GROUPS] > 0:
        words = words_at(given)
        entries = entries_at(work, block, J)
        rows = FIRST + words[N_ENTRIES]
        begins = rows + words[N_ENTRIES]
        for j in range(n):
            if work[WEIGHT, j] == 0.0:
                continue
            for e in range(words[begins + j], words[begins + j + 1]):
                work[FOUND, words[rows + e]] += abs(entries[e]) / work[WEIGHT, j]
        return
    for j in range(n):
        if work[WEIGHT, j] == 0.0:
            continue
        for i in range(max(0, j - s.upper), min(n, j + s.lower + 1)):
            work[FOUND, i] += abs(work[J + j, i]) / work[WEIGHT, j]


@njit(**INTERNAL)
def _renew_matrix(rhs, s, t, work, block, h, c):
    """Factors of I - c df/dy: (status, whether the matrix is regular).

    The norm of the Jacobian is the matrix norm induced by `norm`.
    """
    status = _jacobian(rhs, s, t, work, block, h)
    if status != RUNNING:
        return RUNNING if status == BAD_JACOBIAN else status, False
    _sum_rows(s, work, block)
    s.jacobian_norm = norm(work, FOUND)
    s.factorised = s.current = 1
    s.drift = 1.0
    s.rate = 0.7
    s.age = 0
    return RUNNING, factorise_sum(s, work, block, J, _factors(work, block), PIVOTS, -c, 1.0)


@njit(**INTERNAL)
def _change(s, work, block, h, l0):
    """One iteration; return the norm of the change.  Row RATE has the derivative."""
    n = work.shape[1]
    size = 0.0
    if s.stiff == 0:
        for i in range(n):
            change = h * work[RATE, i] - work[Z + 1, i]
            work[RATE, i] = change - work[CHANGE, i]
            work[CHANGE, i] = change
        size = norm(work, RATE)
    else:
        for i in range(n):
            work[RATE, i] = h * work[RATE, i] - (work[Z + 1, i] + work[CHANGE, i])
        solve_sum(s, work, block, J, _factors(work, block), PIVOTS, RATE, FOUND)
        size = norm(work, RATE)
        for i in range(n):
            work[CHANGE, i] += work[RATE, i]
    for i in range(n):
        work[TRIAL, i] = work[Z, i] + l0 * work[CHANGE, i]
    return size


@njit(**INTERNAL)
def _iterate(rhs, s, t, work, block, h, predicted):
    """Iterate from the predicted state; see `correct`."""
    order = s.order
    l0 = CORRECTION[s.stiff, order, 0]
    enough = SAME[s.stiff, order] * (0.5 / (order + 2))
    fastest = 0.0
    before = 0.0
    size = 0.0
    for i in range(work.shape[1]):
        work[CHANGE, i] = 0.0
    for k in range(ITERATIONS):
        if k > 0:
            before = size
            s.n_extra += 1
            if not evaluate_row(rhs, t, work, TRIAL, RATE, block):
                return RAISED, False, k, size
        size = _change(s, work, block, h, l0)
        if size <= 100.0 * EPS * predicted:
            return RUNNING, True, k + 1, size
        if k > 0:
            rate = size / before if size <= SLOWEST * before else SLOWEST
            fastest = max(fastest, rate)
            s.rate = max(0.2 * s.rate, rate)
        if (k > 0 or s.stiff == 1) and size * min(1.0, 1.5 * s.rate) / enough <= 1.0:
            if s.highest_bdf > 0:  # alone, Adams' formulas would keep the tiny steps of a jump
                s.lipschitz_now = max(s.lipschitz_now, fastest / abs(h * l0))
            if s.lipschitz_now != 0.0:
                s.lipschitz = s.lipschitz_now
            return RUNNING, True, k + 1, size
        if not np.isfinite(size) or (k > 0 and size > 2.0 * before):
            return RUNNING, False, k + 1, size
    return RUNNING, False, ITERATIONS, size


@njit(**INTERNAL)
def correct(rhs, s, t, work, block, h, predicted):
    """Correct the predicted state: (status, converged, iterations, change).

    `predicted` is the norm of the predicted state.  Row TRIAL receives the state, row CHANGE the
    correction of h y'.  If the iteration fails with the Jacobian of an earlier step, the Jacobian
    is renewed.
    """
    c = h * CORRECTION[s.stiff, s.order, 0]
    s.current = 0
    while True:
        copy_row(work[Z], work[TRIAL])
        s.n_extra += 1
        if not evaluate_row(rhs, t, work, TRIAL, RATE, block):
            return RAISED, False, 0, 0.0
        if s.stiff == 1 and s.factorised == 0:
            status, regular = _renew_matrix(rhs, s, t, work, block, h, c)
            if status != RUNNING or not regular:
                return status, False, 0, 0.0
        found = _iterate(rhs, s, t, work, block, h, predicted)
        if found[0] != RUNNING or found[1] or s.stiff == 0 or s.current == 1:
            return found
        s.factorised = 0
