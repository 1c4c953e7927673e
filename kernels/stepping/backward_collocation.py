"""The backward sweep over the steps of an implicit Runge-Kutta method: its discrete adjoint.

With derivatives F_i at the stages, a step of y' = f(t, y) is

    F_i = f(t + c_i h, u_i),   u_i = y + h sum_j a_ij F_j,   y_new = y + h sum_i b_i F_i,

and outputs within the step are combinations of the F_i, too.  So a number has derivatives w_i by
the F_i where they stand in y_new and in outputs.  In reverse, the derivatives kappa_i by f at the
stages solve the transposed equations

    kappa_j - h sum_i a_ij J_i^T kappa_i = w_j,   J_i = df/dy (t + c_i h, u_i),

and the sum of J_i^T kappa_i goes to the derivatives by y.  The stages are solved for again from the
states at both ends, by Newton's iteration with the Jacobians at all stages, whose matrix is that of
the equations in reverse.  The derivatives are thus those of steps whose equations hold to rounding,
whatever the iteration of the solve left.  J. M. Sanz-Serna, "Symplectic Runge-Kutta schemes for
adjoint equations, automatic differentiation, optimal control, and more", SIAM Review 58 (2016).

For q'' = f(t, q), with u_i = q + c_i h v + h^2 sum_j (a^2)_ij F_j, the matrix is one of positions.
The unknowns of a component lie side by side, so that the matrix of a banded Jacobian is banded;
`order` has the place of each component.
"""

import numpy as np

from ..algebra.factorise import factorise, solve, solve_transposed
from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.record import NOT_CONVERGED, RUNNING
from ..state.rows import copy_row, slot
from .backward import clear, pull, take_output, weights

MOST = 30  # iterations
# Changes, in units of the scale: the iteration ends where the next change is below SMALL, and where
# changes below LOOSE, where Newton's iteration of a solve ends, do not decrease.  Factors are kept
# where changes decrease by FAST; on heat in 60 points, a sweep takes a third of the time.
SMALL = 1e-10
LOOSE = 0.03
FAST = 0.1

# The rows of the work array for s stages: F_i, u_i, w_i; then single rows.  OLD has the derivatives
# by the state at the begin.
LAM, _, SCALE, OLD, END, SINGLE = range(6)


@njit(**INTERNAL)
def _states(table, work, y, h, m):
    """Fill the rows u_i from the F_i."""
    s = len(table.c)
    factor = h * h if table.second else h
    for i in range(s):
        for c in range(m):
            rise = 0.0
            for j in range(s):
                rise += table.a[i, j] * work[j, c]
            work[s + i, c] = y[c] + factor * rise
            if table.second:
                work[s + i, c] += table.c[i] * h * y[m + c]


@njit(**INTERNAL)
def _factorise(table, memory, block, t, h, m):
    """Factorise the matrix of the stages, with the Jacobians at the u_i."""
    s = len(table.c)
    a = memory.matrix
    ld = table.ld
    factor = h * h if table.second else h
    for k in range(len(a)):
        a[k] = 0.0
    for k in range(s * m):
        a[k * ld + k] = 1.0
    for i in range(s):
        u = slot(None, memory.work, s + i)
        by_pointer(t + table.c[i] * h, u[:m], block, memory.entries)
        for k in range(len(table.rows)):
            row = table.order[table.rows[k]] * s + i
            first = table.order[table.columns[k]] * s
            for j in range(s):
                a[(first + j) * ld + row] -= factor * table.a[i, j] * memory.entries[k]
    factorise(a, ld, memory.pivots, s * m, table.lower, table.upper)


@njit(**INTERNAL)
def _newton(table, memory, blocks, t, h, m):
    """Change the F_i by a step of Newton's iteration: the largest change of a u_i, in its scale."""
    s = len(table.c)
    work = memory.work
    z = memory.z
    rate = memory.out[:m]
    factor = h * h if table.second else h
    largest = 0.0
    scale = 3 * s + SCALE
    for i in range(s):
        u = slot(None, work, s + i)
        by_pointer(t + table.c[i] * h, u[:m], blocks.own, rate)
        for c in range(m):
            z[table.order[c] * s + i] = rate[c] - work[i, c]
    solve(memory.matrix, table.ld, memory.pivots, z, s * m, table.lower, table.upper)
    for c in range(m):
        at = table.order[c] * s
        for i in range(s):
            work[i, c] += z[at + i]
            change = 0.0
            for j in range(s):
                change += table.a[i, j] * z[at + j]
            change = abs(factor * change)
            if not change < np.inf:
                return np.inf
            if work[scale, c] > 0.0:
                largest = max(largest, change / work[scale, c])
    return largest


@njit(**INTERNAL)
def _stages(table, memory, blocks, t, y, h, m):
    """Find the F_i and u_i from a guess of the F_i, and factorise; whether they were found."""
    before = np.inf
    old = False
    for _ in range(MOST):
        _states(table, memory.work, y, h, m)
        if not old:
            _factorise(table, memory, blocks.jacobian, t, h, m)
        size = _newton(table, memory, blocks, t, h, m)
        if size == np.inf:
            return False
        rate = size / before  # 0 at first
        left = rate * size if rate > 0.0 else size
        if left <= SMALL or (rate >= 0.5 and size <= LOOSE and not old):
            break
        old = rate <= FAST
        before = size
    _states(table, memory.work, y, h, m)
    _factorise(table, memory, blocks.jacobian, t, h, m)
    return size <= LOOSE


@njit(**INTERNAL)
def _end(table, work, y, h, m):
    """Fill the row END with the state at the end of a step."""
    s = len(table.c)
    n = work.shape[1]
    end = 3 * s + END
    copy_row(y, slot(None, work, end))
    for c in range(m):
        for i in range(s):
            work[end, n - m + c] += h * table.b[i] * work[i, c]
        if table.second:
            work[end, c] += h * y[m + c]
            for i in range(s):
                work[end, c] += h * h * table.twice[i] * work[i, c]


@njit(**INTERNAL)
def _found(table, memory, blocks, t, y, y_new, h, m):
    """Find the stages of a step again: RUNNING, or NOT_CONVERGED where they lead elsewhere."""
    s = len(table.c)
    work = memory.work
    n = memory.work.shape[1]
    for i in range(s):
        for c in range(m):
            work[i, c] = (y_new[n - m + c] - y[n - m + c]) / h
    if not _stages(table, memory, blocks, t, y, h, m):
        return NOT_CONVERGED
    _end(table, work, y, h, m)
    for c in range(n):
        gap = abs(work[3 * s + END, c] - y_new[c])
        scale = work[3 * s + SCALE, c]
        if scale > 0.0 and not gap <= table.near * scale:
            return NOT_CONVERGED
    return RUNNING


@njit(**INTERNAL)
def _seed(table, work, beta, g, h, m):
    """Add the derivatives g by y + h sum beta_i F_i to OLD and the w_i."""
    s = len(table.c)
    n = work.shape[1]
    old = 3 * s + OLD
    for c in range(n):
        work[old, c] += g[c]
    for i in range(s):
        twice = 0.0
        if table.second:
            for j in range(s):
                twice += beta[j] * table.inner[j, i]
        for c in range(m):
            work[2 * s + i, c] += h * beta[i] * g[n - m + c]
            if table.second:
                work[2 * s + i, c] += h * h * twice * g[c]
                work[old, m + c] += h * beta[i] * g[c]


@njit(**INTERNAL)
def _take_seeds(table, seeds, work, j, t, h, m):
    """Add the derivatives by the outputs of step j, and by its end, to OLD and the w_i."""
    s = len(table.c)
    lam = slot(None, work, 3 * s + LAM)
    clear(work, 2 * s, 3 * s)
    clear(work, 3 * s + OLD, 3 * s + OLD + 1)
    while take_output(seeds, j, h):
        k = seeds.left[0]
        if seeds.t[k] == seeds.ends[j + 1]:
            for c in range(work.shape[1]):
                lam[c] += seeds.g[k, c]
            continue
        weights(min(max((seeds.t[k] - t) / h, 0.0), 1.0), table.dense, seeds.beta)
        _seed(table, work, seeds.beta, slot(None, seeds.g, k), h, m)
    _seed(table, work, table.b, lam, h, m)


@njit(**INTERNAL)
def _adjoint_step(table, memory, block, t, h, m):
    """From the w_i and OLD of a step to lam at its begin; the stages are known."""
    s = len(table.c)
    work = memory.work
    z = memory.z
    out = memory.out
    lam = 3 * s + LAM
    old = 3 * s + OLD
    for i in range(s):
        for c in range(m):
            z[table.order[c] * s + i] = work[2 * s + i, c]
    solve_transposed(memory.matrix, table.ld, memory.pivots, z, s * m, table.lower, table.upper)
    copy_row(slot(None, work, old), slot(None, work, lam))
    for i in range(s):
        for c in range(m):
            memory.pair[c], memory.pair[m + c] = work[s + i, c], z[table.order[c] * s + i]
        pull(memory, block, t + table.c[i] * h, memory.pair, m)
        for c in range(m):
            work[lam, c] += out[c]
            if table.second:
                work[lam, m + c] += table.c[i] * h * out[c]


@njit(**INTERNAL)
def sweep(table, steps, first, states, seeds, blocks, memory):
    """Go from the last of some steps to the first, and leave lam for the step before.

    The parameters are those of `backward.sweep`; `table` is a Collocation.  NOT_CONVERGED if the
    stages of a step are not found again; z[0] is then the time of this step.
    """
    n = memory.work.shape[1]
    m = n // 2 if table.second else n
    for i in range(len(states) - 2, -1, -1):
        j = first + i
        y = slot(None, states, i)
        t = steps.t[j]
        h = steps.h[j]
        status = _found(table, memory, blocks, t, y, slot(None, states, i + 1), h, m)
        if status != RUNNING:
            memory.z[0] = t
            return status
        _take_seeds(table, seeds, memory.work, j, t, h, m)
        _adjoint_step(table, memory, blocks.pull, t, h, m)
    return RUNNING


@njit(**INTERNAL)
def replay(table, steps, first, states, blocks, memory):
    """Take the steps from number `first` on again: fill states[1:] from states[0].

    The states are those of stages whose equations hold to rounding.
    """
    work = memory.work
    n = memory.work.shape[1]
    s = len(table.c)
    m = n // 2 if table.second else n
    for i in range(len(states) - 1):
        j = first + i
        y = slot(None, states, i)
        work[:s, :] = 0.0
        if not _stages(table, memory, blocks, steps.t[j], y, steps.h[j], m):
            memory.z[0] = steps.t[j]
            return NOT_CONVERGED
        _end(table, work, y, steps.h[j], m)
        copy_row(slot(None, work, 3 * s + END), slot(None, states, i + 1))
    return RUNNING
