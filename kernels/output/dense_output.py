"""Dense output: one polynomial a step, in the form of Hairer, Norsett and Wanner (II.6).

With x = (t - t_old) / h in [0, 1],

    y(x) = y_old + x (F0 + (1 - x) (F1 + x (F2 + (1 - x) (F3 + ...)))).

F0, F1, F2 make the cubic Hermite polynomial of the two ends, for every method; a method of higher
order adds rows.  The polynomial meets both ends of the step to round-off.
"""

from ..calls.block import RAISED_WORD
from ..calls.calling_convention import invoke
from ..jit.options import INLINED, INTERNAL, njit
from ..state.layout import Form
from ..state.record import RAISED, RUNNING, Y_OLD, K, Y
from ..state.rows import keep_vector, numbers_of, vector_at

F = 1  # rows of `d`: y_old, then F0, F1, ...
WIDTH = 4  # components that `polynomial` evaluates together, each rounded as if alone
VECTOR = Form(1, WIDTH, exact=True)


@njit(**INTERNAL)
def hermite(h, fsal_stage, work, d):
    """Fill y_old, F0, F1 and F2 in the rows of d; stages 0 and `fsal_stage` are the slopes."""
    for i in range(d.shape[1]):
        rise = work[Y, i] - work[Y_OLD, i]
        first, final = work[K, i], work[K + fsal_stage, i]
        d[0, i] = work[Y_OLD, i]
        d[F, i] = rise
        d[F + 1, i] = h * first - rise
        d[F + 2, i] = 2.0 * rise - h * (final + first)


@njit(**INTERNAL)
def polynomial(d, x, out):
    """The value at x in [0, 1], written to `out` of length n."""
    n, last, numbers = d.shape[1], d.shape[0] - 1, numbers_of(d)
    whole = n - n % WIDTH
    for i in range(0, whole, WIDTH):
        total = vector_at(VECTOR, numbers, last * n + i) + 0.0
        for j in range(last, 0, -1):
            total = vector_at(VECTOR, numbers, (j - 1) * n + i) + total * _factor(x, j)
        keep_vector(VECTOR, out, i, total)
    for i in range(whole, n):
        total = d[last, i] + 0.0
        for j in range(last, 0, -1):
            total = d[j - 1, i] + total * _factor(x, j)
        out[i] = total


@njit(**INTERNAL)
def _factor(x, j):
    """The factor of row j and of the rows behind it."""
    return x if (j - F) % 2 == 0 else 1.0 - x


@njit(**INTERNAL)
def nest(d, order):
    """Bring a polynomial into the form above; row j of d has the coefficients of (x - 1)^j.

    The polynomial is divided by x and by 1 - x in turn.
    """
    for k in range(order):
        for j in range(order - 1, k - 1, -1):
            for i in range(d.shape[1]):
                if k % 2 == 0:
                    d[j, i] -= d[j + 1, i]
                else:
                    d[k + order - j, i] = -d[k + order - j, i]


@njit(**INLINED)
def cubic(rhs, t, h, work, block, d):
    """Add no rows: the interpolant is the Hermite cubic; 0 evaluations."""
    return 0


@njit(**INTERNAL)
def interpolant(kernels, solve, d):
    """`interpolate` as a kernel: RUNNING, or RAISED."""
    interpolate(kernels, solve, d)
    return RAISED if solve.block[RAISED_WORD] != 0 else RUNNING


@njit(**INTERNAL)
def interpolate(kernels, solve, d):
    """Write the polynomial of the last step to the rows of d."""
    s = solve.state[0]
    h = s.t - s.t_old
    hermite(h, kernels.fsal_stage, solve.work, d)
    s.n_extra += invoke(kernels.dense_rows, (s.t_old, h, solve.work, solve.block, d))
