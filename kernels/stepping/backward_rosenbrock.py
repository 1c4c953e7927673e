"""The backward sweep over the steps of Rodas5P for y' = f(t, y): its discrete adjoint.

The stages U_i of a step from y are, with W = 1 / (h gamma) - J and J = df/dy (t, y),

    W U_i = f(t + c_i h, Y_i) + sum_j C_ij / h U_j + h d_i df/dt (t, y),   Y_i = y + sum_j A_ij U_j,

and y_new is one more Y.  Let lam be the derivatives of a number by y_new.  In reverse, with
eta_i = v_i df/dy (t + c_i h, Y_i),

    v_i W = A_end,i lam + sum_l (A_li eta_l + C_li / h v_l) + seed_i,

where the seeds are those of outputs within the step.  W depends on y and on the parameters, too:
each stage adds the derivatives of v_i J U_i + h d_i v_i df/dt, which are those of the derivative of
f along (U_i, h d_i), to lam and to the gradient.  The last stage of a step is computed from an
equivalent equation; see `methods/rodas5p/step.py`.
"""

from ..algebra.factorise import factorise, solve, solve_transposed
from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.record import RUNNING
from ..state.rows import copy_row, slot
from .backward import clear, pull_to, take_output

# Rows of the work array, for 8 stages: U_i, Y_i, v_i, eta_i, the seeds of U_i; then single rows.
# OLD has the derivatives by the state at the begin, of outputs within the step.
STAGES = 8
U, STATE, V, ETA, SEED = (STAGES * i for i in range(5))
LAM, _, SCALE, OLD, SINGLE = range(5 * STAGES, 5 * STAGES + 5)


@njit(**INTERNAL)
def _factorise(table, memory, blocks, t, y, h):
    """Fill the entries of J and df/dt, and factorise W."""
    n = memory.work.shape[1]
    a = memory.matrix
    ld = table.ld
    by_pointer(t, y, blocks.jacobian, memory.entries)
    for i in range(len(a)):
        a[i] = 0.0
    for i in range(n):
        a[i * ld + i] = 1.0 / (h * table.gamma)
    for k in range(len(table.rows)):
        a[table.columns[k] * ld + table.rows[k]] -= memory.entries[k]
    factorise(a, ld, memory.pivots, n, table.lower, table.upper)


@njit(**INTERNAL)
def _solve(table, memory, x, transposed):
    """Replace x by the solution of W x = x, or of x W = x; W has the components in `order`."""
    n = len(x)
    ordered = memory.z[:n]
    for c in range(n):
        ordered[table.order[c]] = x[c]
    given = memory.matrix, table.ld, memory.pivots, ordered, n, table.lower, table.upper
    if transposed:
        solve_transposed(*given)
    else:
        solve(*given)
    for c in range(n):
        x[c] = ordered[table.order[c]]


@njit(**INTERNAL)
def _state(table, work, i, y, target):
    """Row `target` = the state of stage i; stage 8 is the end."""
    copy_row(y, slot(None, work, target))
    for j in range(min(i, STAGES)):
        for c in range(work.shape[1]):
            work[target, c] += table.a[i, j] * work[U + j, c]


@njit(**INTERNAL)
def _stages(table, memory, blocks, t, y, h):
    """Factorise W, and fill U_i and Y_i."""
    work = memory.work
    n = memory.work.shape[1]
    n_entries = len(table.rows)
    _factorise(table, memory, blocks, t, y, h)
    for i in range(STAGES):
        _state(table, work, i, y, STATE + i)
        u = slot(None, work, U + i)
        by_pointer(t + table.times[i] * h, slot(None, work, STATE + i), blocks.own, u)
        for c in range(n):
            u[c] += h * table.slopes[i] * memory.entries[n_entries + c]
        for j in range(i):
            for c in range(n):
                u[c] += table.c[i, j] / h * work[U + j, c]
        _solve(table, memory, u, False)


@njit(**INTERNAL)
def _take_seeds(table, seeds, work, j, t, h):
    """Add the derivatives by the outputs of step j to lam, OLD and the seeds."""
    n = work.shape[1]
    clear(work, OLD, OLD + 1)
    clear(work, SEED, SEED + STAGES)
    while take_output(seeds, j, h):
        m = seeds.left[0]
        x = 1.0
        if seeds.t[m] != seeds.ends[j + 1]:
            x = min(max((seeds.t[m] - t) / h, 0.0), 1.0)
        for c in range(n):
            work[LAM, c] += x * seeds.g[m, c]
            work[OLD, c] += (1.0 - x) * seeds.g[m, c]
        for i in range(STAGES):
            d = table.dense
            inner = d[0, i] + x * (d[1, i] + d[2, i]) - x * (1.0 - x) * d[2, i]
            for c in range(n):
                work[SEED + i, c] += x * (1.0 - x) * inner * seeds.g[m, c]


@njit(**INTERNAL)
def _adjoint_step(table, memory, blocks, t, y, h):
    """From lam at the end of a step to that at its begin; the stages are known."""
    work = memory.work
    n = memory.work.shape[1]
    z = memory.z
    for i in range(STAGES - 1, -1, -1):
        v = slot(None, work, V + i)
        for c in range(n):
            v[c] = table.a[STAGES, i] * work[LAM, c] + work[SEED + i, c]
        for j in range(i + 1, STAGES):
            for c in range(n):
                v[c] += table.a[j, i] * work[ETA + j, c] + table.c[j, i] / h * work[V + j, c]
        _solve(table, memory, v, True)
        for c in range(n):
            z[c], z[n + c] = work[STATE + i, c], v[c]
        clear(work, ETA + i, ETA + i + 1)
        pull_to(memory, blocks.pull, t + table.times[i] * h, z[: 2 * n], n, ETA + i)
    for i in range(STAGES):
        for c in range(n):
            work[LAM, c] += work[ETA + i, c]
            z[c], z[n + c], z[2 * n + c] = y[c], work[V + i, c], work[U + i, c]
        z[3 * n] = h * table.slopes[i]
        pull_to(memory, blocks.along, t, z, n, LAM)
    for c in range(n):
        work[LAM, c] += work[OLD, c]


@njit(**INTERNAL)
def sweep(table, steps, first, states, seeds, blocks, memory):
    """Go from the last of some steps to the first, and leave lam for the step before.

    The parameters are those of `backward.sweep`; `table` is a Rosenbrock.
    """
    for i in range(len(states) - 2, -1, -1):
        j = first + i
        y = slot(None, states, i)
        t = steps.t[j]
        h = steps.h[j]
        _take_seeds(table, seeds, memory.work, j, t, h)
        _stages(table, memory, blocks, t, y, h)
        _adjoint_step(table, memory, blocks, t, y, h)
    return RUNNING


@njit(**INTERNAL)
def replay(table, steps, first, states, blocks, memory):
    """Take the steps from number `first` on again: fill states[1:] from states[0], to rounding."""
    for i in range(len(states) - 1):
        j = first + i
        y = slot(None, states, i)
        _stages(table, memory, blocks, steps.t[j], y, steps.h[j])
        _state(table, memory.work, STAGES, y, STATE)
        copy_row(slot(None, memory.work, STATE), slot(None, states, i + 1))
    return RUNNING
