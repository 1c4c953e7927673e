"""The backward sweep over the steps of an explicit Runge-Kutta method: its discrete adjoint.

A step is y_new = y + h sum b_i k_i with k_i = f(t + c_i h, u_i) and u_i = y + h sum a_ij k_j.  A
number L that depends on the solution has the derivatives lam by y_new and mu by f(t + h, y_new),
and, going backwards through the stages,

    kappa_i = h sum_l a_li eta_l + seed_i,    eta_i = kappa_i df/dy (t + c_i h, u_i),

where the weights b are one more row of a: the stage of this row is f(t + h, y_new), the first of
the next step.  The adjoint step is thus a step with the transposed table, and with the product of a
row vector and the Jacobian as its right-hand side.  An output within the step is linear in the
stages, y + h sum beta_i(x) k_i, and adds h beta_i dL/d(output) to the seeds.  E. Hairer, C. Lubich
and G. Wanner, "Geometric Numerical Integration", section VI.4; J. M. Sanz-Serna, "Symplectic
Runge-Kutta schemes for adjoint equations, automatic differentiation, optimal control, and more",
SIAM Review 58 (2016).

The table is data, so that one kernel serves all methods.
"""

import numpy as np

from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.record import RUNNING
from ..state.reduce import add, reduce_components
from ..state.rows import copy_row, slot
from ..vector.scalar_or_vector import fused

TINY = 1e-250  # squared size of a cotangent below which it has no direction
LARGEST, RATE, COSINE = range(3)  # in `gauge`
GROWING = 0.2

# The rows of the work array, for S stages: u_i and kappa_i in turn, 2 S rows; then as many k_i,
# which eta_i replaces, and seeds; then single rows.
LAM, MU, ZERO, SUM, SCALE, SINGLE = range(6)


@njit(**INTERNAL)
def _add_four(work, target, i, a, j, b, k, c, m, d):
    """Row `target` += a times row i, then b times row j, and so on."""
    for x in range(work.shape[1]):
        total = fused(a, work[i, x], work[target, x])
        total = fused(b, work[j, x], total)
        total = fused(c, work[k, x], total)
        work[target, x] = fused(d, work[m, x], total)


@njit(**INTERNAL)
def _weighted(work, target, base, h, terms, i, first):
    """Row `target` = row `base` + h sum of the terms of row i, whose values begin at row `first`.

    The roundings are those of `state.elementwise.combine`.  Four terms at a time, in a loop over
    the components, take half the time of all terms in a loop for each component.
    """
    index = terms.index
    value = terms.value
    k = terms.begin[i]
    end = terms.begin[i + 1]
    if k == end:
        copy_row(slot(None, work, base), slot(None, work, target))
        return
    row = first + index[k]
    a = value[k]
    for x in range(work.shape[1]):
        work[target, x] = a * work[row, x]
    k += 1
    while k + 4 <= end:
        _add_four(
            work, target, first + index[k], value[k], first + index[k + 1], value[k + 1],
            first + index[k + 2], value[k + 2], first + index[k + 3], value[k + 3],
        )  # fmt: skip
        k += 4
    while k < end:
        row = first + index[k]
        a = value[k]
        for x in range(work.shape[1]):
            work[target, x] = fused(a, work[row, x], work[target, x])
        k += 1
    for x in range(work.shape[1]):
        work[target, x] = fused(h, work[target, x], work[base, x])


@njit(**INTERNAL)
def _add_row(work, target, row):
    """Row `target` += row `row`."""
    for j in range(work.shape[1]):
        work[target, j] += work[row, j]


@njit(**INTERNAL)
def clear(work, first, end):
    for i in range(first, end):
        for j in range(work.shape[1]):
            work[i, j] = 0.0


@njit(**INTERNAL)
def _stages(table, block, work, t, h, last, used):
    """Fill u_1 to u_last, without the new state, and k_1 to k_used, from y, y_new and k_0."""
    s = table.n_stages
    n_stages = len(table.c)
    for i in range(1, max(last, used) + 1):
        if i != s:
            _weighted(work, 2 * i, 0, h, table.rows, i, 2 * n_stages)
        if i <= used:
            u = slot(None, work, 2 * i)
            k = slot(None, work, 2 * n_stages + i)
            by_pointer(t + table.c[i] * h, u, block, k)


@njit(**INTERNAL)
def product(total, x, y, scale):
    return total + (x * scale) * (y * scale)


@njit(**INTERNAL)
def _measure(memory, kappa, eta, h, n_stages):
    """Keep where |h| |eta| / |kappa| is largest: that, without h, and the cosine of the two.

    The norm is that of the tolerances.  The fastest modes soon dominate a cotangent: rate and
    cosine are size and angle of the eigenvalue of the Jacobian that limits the steps.  No step is
    short enough for a motion that grows by itself, of cosine above GROWING.
    """
    work = memory.work
    gauge = memory.gauge
    kappa = slot(None, work, kappa)
    eta = slot(None, work, eta)
    scale = slot(None, work, 4 * n_stages + SCALE)
    before = reduce_components(product, add, 0.0, (kappa, kappa, scale))
    after = reduce_components(product, add, 0.0, (eta, eta, scale))
    if before > TINY and after < np.inf:
        if after * h * h > gauge[LARGEST] * gauge[LARGEST] * before:
            rate = np.sqrt(after / before)
            both = reduce_components(product, add, 0.0, (kappa, eta, scale))
            cosine = both / (before * rate) * (1.0 if h > 0.0 else -1.0)
            if cosine <= GROWING:
                gauge[LARGEST] = abs(h) * rate
                gauge[RATE] = rate
                gauge[COSINE] = cosine


@njit(**INTERNAL)
def pull(memory, block, t, z, m):
    """Write a vjp's m derivatives by the state to `out`; the others are added to the gradient."""
    for c in range(m):
        memory.out[c] = 0.0
    by_pointer(t, z, block, memory.out)


@njit(**INTERNAL)
def pull_to(memory, block, t, z, m, target):
    """Row `target` += a vjp's m derivatives by the state: see `pull`."""
    pull(memory, block, t, z, m)
    for c in range(m):
        memory.work[target, c] += memory.out[c]


@njit(**INTERNAL)
def _pull(memory, own, t, i, target):
    """Row `target` = kappa_i df/dy at u_i; kappa_i df/dp is added to the gradient."""
    work = memory.work
    pull(memory, own, t, slot(None, memory.pairs, i), work.shape[1])
    for j in range(work.shape[1]):
        work[target, j] = memory.out[j]


@njit(**INTERNAL)
def take_output(seeds, j, h):
    """Take the last output left, number left[0] then; False if it does not belong to step j.

    Outputs at the begin of the step, of length h, belong to the step before, if there is one.
    """
    left = seeds.left
    if left[0] > 0 and (j == 0 or (seeds.t[left[0] - 1] - seeds.ends[j]) * h > 0.0):
        left[0] -= 1
        return True
    return False


@njit(**INTERNAL)
def weights(x, dense, beta):
    """The weights of the stages in the interpolant at x; see `output/dense_output.py`."""
    for j in range(len(beta)):
        beta[j] = 0.0
    factor = 1.0
    for i in range(dense.shape[0]):
        factor *= x if i % 2 == 0 else 1.0 - x
        for j in range(len(beta)):
            beta[j] += factor * dense[i, j]


@njit(**INTERNAL)
def _take_seeds(table, seeds, work, j, t, h):
    """Add the derivatives by the outputs of step j to lam and to seeds; True if some are inside.

    The step takes h from t on.
    """
    n_stages = len(table.c)
    n = work.shape[1]
    inside = False
    seed = 3 * n_stages
    single = 4 * n_stages
    while take_output(seeds, j, h):
        m = seeds.left[0]
        if seeds.t[m] == seeds.ends[j + 1]:
            for c in range(n):
                work[single + LAM, c] += seeds.g[m, c]
            continue
        if not inside:
            inside = True
            clear(work, seed, seed + n_stages)
            clear(work, single + SUM, single + SUM + 1)
        weights(min(max((seeds.t[m] - t) / h, 0.0), 1.0), table.dense, seeds.beta)
        for r in range(n_stages):
            if seeds.beta[r] != 0.0:
                for c in range(n):
                    work[seed + r, c] += h * seeds.beta[r] * seeds.g[m, c]
        for c in range(n):
            work[single + SUM, c] += seeds.g[m, c]
    return inside


@njit(**INTERNAL)
def _adjoint_step(table, memory, block, own, t, h, inside):
    """From lam and mu at the end of a step to those at its begin.

    `inside` tells whether stages have seeds; only then the stages of the interpolant matter.
    """
    work = memory.work
    s = table.n_stages
    n_stages = len(table.c)
    first = 2 * n_stages
    seed = 3 * n_stages
    single = 4 * n_stages
    last = n_stages - 1 if inside else s
    columns = table.seeded if inside else table.columns
    by_pointer(t, slot(None, work, 0), block, slot(None, work, first))
    _stages(table, block, work, t, h, last, table.used[int(inside)])
    for i in range(last, -1, -1):
        base = seed + i if inside else single + ZERO
        eta = first + i
        kappa = 2 * i + 1
        if i == 0:
            _weighted(work, single + MU, base, h, columns, i, first)
            break
        if i != s and not inside and columns.begin[i] == columns.begin[i + 1]:
            clear(work, eta, eta + 1)  # a stage of the error estimate alone
            continue
        _weighted(work, kappa, base, h, columns, i, first)
        if i == s:
            _add_row(work, kappa, single + MU)
        _pull(memory, own, t + table.c[i] * h, i, eta)
        if i == s:
            _measure(memory, kappa, eta, h, n_stages)
            _add_row(work, eta, single + LAM)
    copy_row(slot(None, work, first + s), slot(None, work, single + LAM))
    for i in range(1, last + 1):
        if i != s:
            _add_row(work, single + LAM, first + i)


@njit(**INTERNAL)
def sweep(table, steps, first, states, seeds, block, own, memory):
    """Go from the last of some steps to the first, and leave lam and mu for the step before.

    Parameters
    ----------
    table : Table
    steps : Steps
        All steps of a solve.
    first : int
        The number of the first step of the sweep.
    states : array, (n_steps + 1, n)
        The states at the ends of these steps, that before the first step included.
    seeds : Seeds
    block, own : arrays of words
        The blocks of the equations and of their vjp.
    memory : Memory
        `out` has n numbers of no meaning, and then the gradient.
    """
    work = memory.work
    n_stages = len(table.c)
    single = 4 * n_stages
    for i in range(len(states) - 2, -1, -1):
        j = first + i
        t = steps.t[j]
        h = steps.h[j]
        inside = _take_seeds(table, seeds, work, j, t, steps.end[j] - t)
        copy_row(slot(None, states, i), slot(None, work, 0))
        copy_row(slot(None, states, i + 1), slot(None, work, 2 * table.n_stages))
        _adjoint_step(table, memory, block, own, t, h, inside)
        if inside:
            _add_row(work, single + LAM, single + SUM)
        if steps.fresh[j] != 0:
            copy_row(slot(None, work, single + MU), slot(None, work, 1))
            _pull(memory, own, t, 0, 2 * n_stages)
            _add_row(work, single + LAM, 2 * n_stages)
            clear(work, single + MU, single + MU + 1)
    return RUNNING


@njit(**INTERNAL)
def _begin_step(table, steps, block, work, j):
    """The first derivative of step j, from that at the end of the step before.

    At the start of a segment the state moves as in `output/segments.py`.
    """
    n = work.shape[1]
    begin = 2 * len(table.c)
    end = begin + table.n_stages
    if steps.fresh[j] == 0:
        copy_row(slot(None, work, end), slot(None, work, begin))
        return
    gap = 0.5 * (steps.t[j] - steps.end[j - 1]) if j > 0 else 0.0
    if j > 0:
        for c in range(n):
            work[0, c] += gap * work[end, c]
    by_pointer(steps.t[j], slot(None, work, 0), block, slot(None, work, begin))
    if j > 0:
        for c in range(n):
            work[0, c] += gap * work[begin, c]


@njit(**INTERNAL)
def replay(table, steps, first, states, block, work):
    """Take the steps from number `first` on again: fill states[1:] from states[0].

    The bits are those of the solve.
    """
    s = table.n_stages
    n_stages = len(table.c)
    end = 2 * n_stages + s
    copy_row(slot(None, states, 0), slot(None, work, 0))
    if first > 0:
        by_pointer(
            steps.t[first - 1] + steps.h[first - 1],
            slot(None, work, 0),
            block,
            slot(None, work, end),
        )
    for i in range(len(states) - 1):
        j = first + i
        _begin_step(table, steps, block, work, j)
        t = steps.t[j]
        h = steps.h[j]
        _stages(table, block, work, t, h, s - 1, s - 1)
        _weighted(work, 2 * s, 0, h, table.rows, s, 2 * n_stages)
        by_pointer(t + h, slot(None, work, 2 * s), block, slot(None, work, end))
        copy_row(slot(None, work, 2 * s), slot(None, states, i + 1))
        copy_row(slot(None, work, 2 * s), slot(None, work, 0))
    return RUNNING
