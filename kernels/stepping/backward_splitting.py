"""The backward sweep over the steps of a symplectic method of kicks and drifts.

A drift q += d h v has the adjoint lam_v += d h lam_q; a kick v += p h a(t, q) has
lam_q += p h lam_v da/dq, where lam_q and lam_v are the derivatives of a number by q and v.  So a
step in reverse has the same table, and the product of a row vector and the Jacobian of a in place
of a.  The acceleration at the end of a step serves the first kick of the next one: the derivatives
by it, mu, go to the step before.  An output within the step is a combination of the states and the
slopes at both ends and at the ends of shorter steps, which are gone back like the step itself.  E.
Hairer, C. Lubich and G. Wanner, "Geometric Numerical Integration", section VI.4.

The table is data, so that one kernel serves all methods.
"""

import numpy as np

from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.record import RUNNING
from ..state.reduce import add, reduce_components
from ..state.rows import copy_row, slot
from .backward import COSINE, LARGEST, RATE, TINY, clear, product, pull_to, take_output

# The rows of the work array, for s drifts: q_j and kappa_j side by side, s + 1 rows; then single
# rows; then two rows for each shorter step, derivatives by the state and by (v, a) at its end.
# OLD has the derivatives by the state at the begin, FIRST and LAST those by (v, a) at begin and
# end, of the outputs within a step.
LAM, MU, V, SCALE, OLD, FIRST, LAST, SUM_LAM, SUM_MU, SINGLE = range(10)


@njit(**INTERNAL)
def _forward(table, block, work, rate, t, h):
    """From q_0 and v to all q_j; v is then that before the last kick."""
    s = len(table.drifts)
    m = len(rate)
    v = s + 1 + V
    for j in range(s):
        at = t if j == 0 else t + table.times[j - 1] * h
        by_pointer(at, work[j, :m], block, rate)
        for c in range(m):
            work[v, c] += table.kicks[j] * h * rate[c]
            work[j + 1, c] = work[j, c] + table.drifts[j] * h * work[v, c]


@njit(**INTERNAL)
def _take_seeds(table, seeds, work, single, j, t, h):
    """Add the derivatives by the outputs of step j to lam, OLD, FIRST, LAST and the shorter steps.

    True if an output depends on the shorter steps.
    """
    beta = seeds.beta
    within = False
    n_rows = len(table.dense)
    clear(work, single + OLD, single + LAST + 1)
    clear(work, single + SINGLE, single + SINGLE + n_rows - 4)
    while take_output(seeds, j, h):
        i = seeds.left[0]
        if seeds.t[i] == seeds.ends[j + 1]:
            for c in range(work.shape[1]):
                work[single + LAM, c] += seeds.g[i, c]
            continue
        within = n_rows > 4
        x = min(max((seeds.t[i] - t) / h, 0.0), 1.0)
        factor = 1.0
        for k in range(n_rows):
            beta[k] = table.dense[0, k]
        for row in range(1, n_rows):
            factor *= x if row % 2 else 1.0 - x
            for k in range(n_rows):
                beta[k] += factor * table.dense[row, k]
        for c in range(work.shape[1]):
            g = seeds.g[i, c]
            work[single + OLD, c] += beta[0] * g
            work[single + FIRST, c] += h * beta[1] * g
            work[single + LAM, c] += beta[2] * g
            work[single + LAST, c] += h * beta[3] * g
            for k in range(4, n_rows):
                work[single + SINGLE + k - 4, c] += (h if k % 2 else 1.0) * beta[k] * g
    return within


@njit(**INTERNAL)
def _measure(memory, kappa, scale, m, h):
    """Keep where h^2 |eta| / |kappa| is largest, eta = kappa da/dq: see `backward.py`.

    For q'' = -w^2 q, the ratio is w^2: the rate is its root, and the cosine is -1.
    """
    gauge = memory.gauge
    eta = memory.out[:m]
    before = reduce_components(product, add, 0.0, (kappa, kappa, scale))
    after = reduce_components(product, add, 0.0, (eta, eta, scale))
    if before > TINY and after < np.inf:
        rate = np.sqrt(after / before)
        if rate * h * h > gauge[LARGEST] * gauge[LARGEST]:
            both = reduce_components(product, add, 0.0, (kappa, eta, scale))
            gauge[RATE] = np.sqrt(rate)
            gauge[LARGEST] = abs(h) * gauge[RATE]
            gauge[COSINE] = both / (before * rate)


@njit(**INTERNAL)
def _pull(memory, own, t, j, m, lam):
    """Add kappa_j da/dq at q_j to lam_q, and kappa_j da/dp to the gradient."""
    pull_to(memory, own, t, slot(None, memory.work, j), m, lam)


@njit(**INTERNAL)
def _adjoint_step(table, memory, own, t, h):
    """From lam and mu at the end of a step to those at its begin; all q_j are known."""
    work = memory.work
    s = len(table.drifts)
    m = work.shape[1] // 2
    single = s + 1
    lam = single + LAM
    mu = single + MU
    for c in range(m):
        work[lam, m + c] += work[single + LAST, c]
        kick = table.kicks[s] * h * work[lam, m + c]
        work[s, m + c] = kick + work[mu, c] + work[single + LAST, m + c]
    _pull(memory, own, t + h, s, m, lam)
    _measure(memory, work[s, m:], work[single + SCALE, :m], m, h)
    for j in range(s, 0, -1):
        for c in range(m):
            work[lam, m + c] += table.drifts[j - 1] * h * work[lam, c]
            work[j - 1, m + c] = table.kicks[j - 1] * h * work[lam, m + c]
        if j > 1:
            _pull(memory, own, t + table.times[j - 2] * h, j - 1, m, lam)
    for c in range(m):
        work[mu, c] = work[0, m + c] + work[single + FIRST, m + c]
        work[lam, c] += work[single + OLD, c]
        work[lam, m + c] += work[single + OLD, m + c] + work[single + FIRST, c]


@njit(**INTERNAL)
def _back(table, memory, block, own, state, t, h):
    """Go back over the step of size h from a state."""
    work = memory.work
    m = len(state) // 2
    for c in range(m):
        work[0, c], work[len(table.drifts) + 1 + V, c] = state[c], state[m + c]
    _forward(table, block, work, memory.out[:m], t, h)
    _adjoint_step(table, memory, own, t, h)


@njit(**INTERNAL)
def _shorter_steps(table, memory, block, own, state, t, h):
    """Go back over the shorter steps of the interpolant; lam and mu are sums over all."""
    work = memory.work
    single = len(table.drifts) + 1
    lam = single + LAM
    mu = single + MU
    total = single + SUM_LAM
    copy_row(slot(None, work, lam), slot(None, work, total))
    copy_row(slot(None, work, mu), slot(None, work, total + 1))
    for k in range(len(table.nodes)):
        seed = single + SINGLE + 2 * k
        copy_row(slot(None, work, seed), slot(None, work, lam))
        copy_row(slot(None, work, seed + 1), slot(None, work, single + LAST))
        for row in (mu, single + OLD, single + FIRST):
            clear(work, row, row + 1)
        _back(table, memory, block, own, state, t, table.nodes[k] * h)
        for c in range(work.shape[1]):
            work[total, c] += work[lam, c]
            work[total + 1, c] += work[mu, c]
    copy_row(slot(None, work, total), slot(None, work, lam))
    copy_row(slot(None, work, total + 1), slot(None, work, mu))


@njit(**INTERNAL)
def sweep(table, steps, first, states, seeds, block, own, memory):
    """Go from the last of some steps to the first, and leave lam and mu for the step before.

    The parameters are those of `backward.sweep`; `table` is a Splitting, and `out` has m numbers of
    no meaning, for the m positions, and then the gradient.
    """
    work = memory.work
    m = work.shape[1] // 2
    single = len(table.drifts) + 1
    for i in range(len(states) - 2, -1, -1):
        j = first + i
        t = steps.t[j]
        h = steps.h[j]
        within = _take_seeds(table, seeds, work, single, j, t, steps.end[j] - t)
        _back(table, memory, block, own, states[i], t, h)
        if within:
            _shorter_steps(table, memory, block, own, states[i], t, h)
        if steps.fresh[j] != 0:
            for c in range(m):
                work[0, m + c] = work[single + MU, c]
            _pull(memory, own, t, 0, m, single + LAM)
            clear(work, single + MU, single + MU + 1)
    return RUNNING


@njit(**INTERNAL)
def replay(table, steps, first, states, block, work):
    """Take the steps from number `first` on again: fill states[1:] from states[0].

    The states are those of the solve but for its compensation of rounding errors.
    """
    s = len(table.drifts)
    m = work.shape[1] // 2
    v = s + 1 + V
    rate = work[s + 1 + OLD, :m]
    for i in range(len(states) - 1):
        j = first + i
        t = steps.t[j]
        h = steps.h[j]
        for c in range(m):
            work[0, c], work[v, c] = states[i, c], states[i, m + c]
        _forward(table, block, work, rate, t, h)
        by_pointer(t + h, work[s, :m], block, rate)
        for c in range(m):
            states[i + 1, c] = work[s, c]
            states[i + 1, m + c] = work[v, c] + table.kicks[s] * h * rate[c]
    return RUNNING
