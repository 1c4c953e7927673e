"""The stages of a step of Radau, and the rows of the work array.

With Z_i = Y_i - y and W = T^-1 Z, Newton's iteration splits into a real and a complex system of n
equations: E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and
Differential-Algebraic Problems", second edition, section IV.8.
"""

import numpy as np

from ...algebra.complex_matrices import factorise_complex_sum, solve_complex_sum
from ...algebra.mass import add_product, widened
from ...algebra.matrices import factorise_sum, matrix_rows, rare, solve_sum
from ...calls.block import MASS, PAST_OF_RARE, RAISED_WORD, RARE
from ...calls.user_function import numbers_at, words_at
from ...jit.options import INLINED, INTERNAL, njit
from ...output.arguments import PAST_TRIAL
from ...state.record import RAISED, RUNNING, STAGE, Y_OLD, K, Y
from ...stepping.differences import evaluate_row, keep_factors
from ...stepping.implicit import n_components, scaled_squares, take_larger
from ...stepping.jacobian import evaluate_jacobian, is_constant

ROOT = 6**0.5
C = ((4 - ROOT) / 10, (4 + ROOT) / 10, 1.0)
REAL = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)  # the eigenvalues of A^-1: REAL, and a complex pair
ALPHA = 3 + 0.5 * (3 ** (1 / 3) - 3 ** (2 / 3))
BETA = -0.5 * (3 ** (5 / 6) + 3 ** (7 / 6))
T = np.array(
    [
        [0.09443876248897524, -0.14125529502095421, 0.03002919410514742],
        [0.25021312296533332, 0.20412935229379994, -0.38294211275726192],
        [1, 1, 0],
    ]
)
INVERSE = np.array(
    [
        [4.17871859155190428, 0.32768282076106237, 0.52337644549944951],
        [-4.17871859155190428, -0.32768282076106237, 0.47662355450055044],
        [0.50287263494578682, -2.57192694985560522, 0.59603920482822492],
    ]
)
P = np.array(  # the polynomial through the stages: powers 1 to 3
    [
        [13 / 3 + 7 * ROOT / 3, -23 / 3 - 22 * ROOT / 3, 10 / 3 + 5 * ROOT],
        [13 / 3 - 7 * ROOT / 3, -23 / 3 + 22 * ROOT / 3, 10 / 3 - 5 * ROOT],
        [1 / 3, -8 / 3, 10 / 3],
    ]
)
MAX_ITERATIONS = 6  # as in SciPy

# Rows: the derivative at the start of a step, the polynomial of the last step, the stages Z, their
# transforms W, derivatives at the stages or changes of W, the error and its correction, factors of
# differences and two rows of work space, pivots, the largest |f| in a step.
SLOPE, Q, Z, W, D, ERROR, CORRECTION, FACTOR, PIVOTS, MOST = (
    K + i for i in (1, 2, 5, 8, 11, 14, 15, 16, 19, 21)
)
N_ROWS = 22
J = K + N_ROWS  # the first row of the Jacobian; behind lie the factors of both systems


@njit(**INLINED)
def _transform(m, work, given, found):
    """The three rows `found` as the matrix m times the three rows `given`."""
    for i in range(work.shape[1]):
        a = work[given, i]
        b = work[given + 1, i]
        c = work[given + 2, i]
        for r in range(3):
            work[found + r, i] = m[r, 0] * a + m[r, 1] * b + m[r, 2] * c


@njit(**INLINED)
def _complex_at(work, block):
    """The first row of the factors of the complex system, behind the factors of the real system."""
    return J + 2 * matrix_rows(block, work.shape[1])


@njit(**INTERNAL)
def _factorise(s, work, block, h):
    """Factorise both systems for a step of this size."""
    real = J + matrix_rows(block, work.shape[1])
    factorise_sum(s, work, block, J, real, PIVOTS, -1.0, REAL / h)
    given = PIVOTS + 1, -1.0, ALPHA / h, BETA / h
    factorise_complex_sum(s, work, block, J, _complex_at(work, block), *given)
    s.factorised = 1


@njit(**INTERNAL)
def solve_real(s, work, block, row):
    real = J + matrix_rows(block, work.shape[1])
    solve_sum(s, work, block, J, real, PIVOTS, row, FACTOR + 1)


@njit(**INTERNAL)
def _subtract_products(work, block, real, alpha, beta):
    """From the rows D, subtract M times multiples of W."""
    for r in range(3):
        for i in range(work.shape[1]):
            a = work[W, i]
            u = work[W + 1, i]
            v = work[W + 2, i]
            times = real * a if r == 0 else alpha * u - beta * v if r == 1 else alpha * v + beta * u
            work[STAGE, i] = -times
        add_product(block[MASS], work[STAGE], work[D + r])


@njit(**INTERNAL)
def _newton_change(s, work, block, h):
    """Replace the derivatives at the stages, in the rows D, by the change of W."""
    n = work.shape[1]
    real = REAL / h
    alpha = ALPHA / h
    beta = BETA / h
    _transform(INVERSE, work, D, D)
    if block[MASS] != 0:
        _subtract_products(work, block, real, alpha, beta)
    else:
        for i in range(n):
            u = work[W + 1, i]
            v = work[W + 2, i]
            work[D, i] -= real * work[W, i]
            work[D + 1, i] -= alpha * u - beta * v
            work[D + 2, i] -= alpha * v + beta * u
    solve_real(s, work, block, D)
    given = PIVOTS + 1, D + 1, ERROR
    solve_complex_sum(s, work, block, J, _complex_at(work, block), *given)


@njit(**INTERNAL)
def _tell_past(s, work, words, h):
    """Let the past within the step of a delay equation be the polynomial through the stages.

    N. Guglielmi and E. Hairer, "Implementing Radau IIA methods for stiff delay differential
    equations", Computing 67 (2001): Newton's iteration then converges for delays far shorter than
    the step, too.  Their matrix is kept as small by one weight for all stages, here 1 - tau / h.
    """
    n = work.shape[1]
    trial = numbers_at(words[PAST_TRIAL])
    trial[0] = s.t
    trial[1] = h
    for i in range(n):
        a = work[Z, i]
        b = work[Z + 1, i]
        c = work[Z + 2, i]
        q1 = P[0, 1] * a + P[1, 1] * b + P[2, 1] * c
        q2 = P[0, 2] * a + P[1, 2] * b + P[2, 2] * c
        trial[2 + i] = work[Y, i]
        trial[2 + n + i] = c
        trial[2 + 2 * n + i] = -q1 - q2
        trial[2 + 3 * n + i] = -q2


@njit(**INLINED)
def _stages(rhs, s, work, block, h):
    """Evaluate the derivatives at the stages into the rows D; return whether all are finite.

    If the function raises, RAISED_WORD of its block is set.
    """
    finite = True
    if block[RARE] != 0 and rare(block, PAST_OF_RARE) != 0:
        _tell_past(s, work, words_at(rare(block, PAST_OF_RARE)), h)
    for r in range(3):
        for i in range(work.shape[1]):
            work[STAGE, i] = work[Y, i] + work[Z + r, i]
        s.n_extra += 1
        if not evaluate_row(rhs, s.t + h * C[r], work, STAGE, D + r, block):
            return False
        for i in range(work.shape[1]):
            finite = finite and np.isfinite(work[D + r, i])
        take_larger(work, MOST, D + r)
    return finite


@njit(**INTERNAL)
def _iterate(rhs, s, work, block, h, tolerance):
    """Newton's iteration from the stages Z: (converged, iterations, rate of convergence)."""
    _transform(INVERSE, work, Z, W)
    rate = before = 0.0
    for k in range(MAX_ITERATIONS):
        if not _stages(rhs, s, work, block, h):
            return False, k + 1, rate
        _newton_change(s, work, block, h)
        total = 0.0
        for r in range(3):
            total += scaled_squares(s, work, D + r, Y)
        size = np.sqrt(total / (3 * n_components(s, work)))
        if k > 0:
            rate = size / before
            left = rate ** (MAX_ITERATIONS - k) / (1.0 - rate) * size
            if rate >= 1.0 or left > tolerance:
                return False, k + 1, rate
        for r in range(3):
            for i in range(work.shape[1]):
                work[W + r, i] += work[D + r, i]
        _transform(T, work, W, Z)
        if size == 0.0 or (k > 0 and rate / (1.0 - rate) * size < tolerance):
            return True, k + 1, rate
        before = size
    return False, MAX_ITERATIONS, rate


@njit(**INTERNAL)
def _predict(s, work, h):
    """Predict the stages of a step of size h by the polynomial of the last step, or by 0."""
    h_old = s.t - s.t_old
    for i in range(work.shape[1]):
        behind = work[Y_OLD, i] - work[Y, i]
        q0 = work[Q, i]
        q1 = work[Q + 1, i]
        q2 = work[Q + 2, i]
        for r in range(3):
            work[Z + r, i] = 0.0
            if s.n_equal > 0:
                x = (s.t + h * C[r] - s.t_old) / h_old
                work[Z + r, i] = behind + (q0 + (q1 + q2 * x) * x) * x


@njit(**INTERNAL)
def renew_jacobian(rhs, s, work, block):
    """The Jacobian at the present state; RUNNING, RAISED or BAD_JACOBIAN."""
    s.current = 1
    s.factorised = 0
    s.n_jacobians += not is_constant(block)
    status = evaluate_jacobian(s, s.t, work, Y, SLOPE, block, FACTOR, J)
    if block[MASS] != 0:
        keep_factors(work, FACTOR)
        s.lower, s.upper = widened(block[MASS], s.lower, s.upper)
    return status


@njit(**INTERNAL)
def solve_stages(rhs, s, work, block, h, tolerance):
    """Find Z for a step of size h, with a new Jacobian if need be.

    Returns (status, converged, iterations, rate of convergence).
    """
    while True:
        if s.factorised == 0:
            _factorise(s, work, block, h)
        _predict(s, work, h)
        converged, n_iterations, rate = _iterate(rhs, s, work, block, h, tolerance)
        status = RAISED if block[RAISED_WORD] != 0 else RUNNING
        if status == RUNNING and not converged and s.current == 0:
            status = renew_jacobian(rhs, s, work, block)
            if status == RUNNING:
                continue
        return status, converged, n_iterations, rate
