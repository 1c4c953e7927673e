"""A consistent start of F(t, y, y') = 0, by Newton's iteration with a line search.

P. N. Brown, A. C. Hindmarsh and L. R. Petzold, "Consistent initial condition calculation for
differential-algebraic systems", SIAM J. Sci. Comput. 19 (1998).
"""

import numpy as np

from fastdyn.run.matrices.check_jacobian import STEP

from .equations import DENSE, beside
from .index import (
    check_index,
    check_large_index,
    check_structure,
    large_rates,
    names,
    null_spaces,
)

ITERATIONS = 100
HALVINGS = 40
DESCENT = 1e-4  # the share of the linear decrease that a step must reach
CLOSE = 1e-10  # of the last change, relative to the numbers
ROUNDING = 1e-9  # of derivatives that fulfil the equations
NEAR = 1e-3  # of the last change, in units of the tolerance, where rounding stops the iteration


def consistent(equations, problem, given):
    """[y, y'] with F = 0, from the start of a problem; ValueError without."""
    p = problem
    both = problem.y0
    jacobian = equations.jacobian(both)
    rates = equations.rates(both)
    if not rates.any():
        raise ValueError(
            "`F` does not depend on `yp`: its equations are algebraic, without an initial value "
            "problem; scipy.optimize.root solves them at each time."
        )
    wrong = _singular(equations, both)
    if wrong is not None and all(_singular(equations, state) for state in beside(both)):
        raise wrong
    if given is None:
        _check(equations, p, jacobian)
    else:
        both = _newton(equations, p, both, ~held_of(given, rates), given)
        wrong = _singular(equations, both)
    if wrong is not None:
        raise wrong
    if isinstance(given, str) and given != "yp":
        free = ~held_of(given, rates)
        return _with_all_derivatives(equations, p, both, rates, free, given)
    return both


def consistent_behind(equations, problem, t, both):
    """[y, y'] with F = 0 behind a jump at t; an exception of F there is the user's, and is raised.

    Components whose derivatives occur in F are held, others and all derivatives are computed.
    """
    there = equations.at(t)
    there.raise_own(both)
    return consistent(there, problem._replace(t0=t, y0=both), "differential")


def _with_all_derivatives(equations, p, both, rates, free, given):
    """[y, y'] with the part of y' that does not occur in F: the constraints hold at all times.

    Combinations u of the equations without derivatives give u (dF/dt + dF/dy y') = 0.
    """
    n = equations.n
    jacobian = equations.jacobian(both)
    span = abs(p.tf - p.t0)
    step = STEP * max(abs(p.t0), min(span, 1.0) if span > 0.0 else 1.0)
    by_time = equations.by_time(both, step if p.tf >= p.t0 else -step)
    values = jacobian if isinstance(jacobian, np.ndarray) else jacobian.data
    if not (np.isfinite(by_time).all() and np.isfinite(values).all()):
        return both
    rate = completed(equations, jacobian, rates, both[n:], by_time)
    if rate is None:
        return both
    new = np.concatenate([both[:n], rate])
    if not np.isfinite(equations.residual(new)).all():
        return both
    try:  # the shortest change keeps what is new
        return _newton(equations, p._replace(y0=new), new, free, given)
    except ValueError:
        return both


def completed(equations, jacobian, rates, rate, by_time):
    """y' with the part that does not occur in F, such that the constraints hold at all times.

    Combinations u of the equations without derivatives give u (dF/dt + dF/dy y') = 0; `by_time` is
    dF/dt.  Both may be matrices, a column a direction.  None if all derivatives occur.
    """
    n = equations.n
    if n > DENSE:
        found = large_rates(jacobian, n, rate, by_time)
        rate = rate.copy()
        rate[~rates] = found[~rates]
        return rate
    left, right = null_spaces(jacobian, n, equations.noise)
    B = jacobian[:, :n]
    if not left.size:
        return None
    change = _full_solution(left.T @ B @ right, -left.T @ (by_time + B @ rate), n * equations.noise)
    return rate + right @ change


def _singular(equations, both):
    """The ValueError that says why the equations are not of index 1 at a state, or None."""
    jacobian = equations.jacobian(both)
    n = equations.n
    try:
        if n > DENSE:
            check_large_index(jacobian, n)
        elif np.isfinite(jacobian).all():
            check_index(jacobian, n, equations.noise)
    except ValueError as reason:
        try:
            if equations.pattern is not None:
                check_structure(equations.pattern, n)
        except ValueError as structure:  # says more
            return structure
        return reason
    return None


def held_of(given, rates):
    """The numbers of [y, y'] that are held; `rates` marks the derivatives that occur in F."""
    if not isinstance(given, str):
        return given
    none = np.zeros_like(rates)
    all_ = np.ones_like(rates)
    halves = {"differential": (rates, ~rates), "y": (all_, ~rates), "yp": (none, all_)}
    return np.concatenate(halves[given])


def _tolerance(p, both):
    """The tolerance of the numbers of [y, y']; of y' the change that moves y by its tolerance."""
    span = abs(p.tf - p.t0)
    n = len(p.y0) // 2
    unit = np.concatenate([np.ones(n), np.full(n, 1.0 / span if span > 0.0 else 1.0)])
    return p.atol * unit + p.rtol * np.abs(both)


def _check(equations, p, jacobian):
    """Raise ValueError if F is not 0 at the start to within the tolerance of its unknowns."""
    off = np.abs(equations.residual(p.y0))
    allowed = abs(jacobian) @ _tolerance(p, p.y0)
    wrong = np.flatnonzero(~(off <= allowed))
    if wrong.size:
        worst = wrong[np.argmax(off[wrong])]
        raise ValueError(
            f"`y0` and `yp0` are not consistent: {names('equation', wrong)} of `F` "
            f"{'is' if wrong.size == 1 else 'are'} not 0 (equation {worst} is {off[worst]:.2g}). "
            "Let the start be computed: given='differential' holds the components of `y0` whose "
            "derivatives occur in `F`, given='y' all of `y0`."
        )


def _newton(equations, p, both, free, given):
    """Change the free numbers until F = 0; ValueError if that fails."""
    both, n, tolerance = both.copy(), equations.n, _tolerance(p, both)
    held = f"given={given!r}" if isinstance(given, str) else "`given`"
    f = equations.residual(both)
    for _ in range(ITERATIONS):
        jacobian = equations.jacobian(both)
        values = jacobian if isinstance(jacobian, np.ndarray) else jacobian.data
        if not np.isfinite(values).all():
            raise ValueError(
                f"The Jacobian of `F` is nan or inf near the start, at y = {both[:n].tolist()}: "
                "start elsewhere."
            )
        change, size = _change(jacobian[:, free], f, n * equations.noise)
        found = _line_search(equations, both, free, change, size)
        if found is not None:
            both, f = found
            tolerance = np.maximum(tolerance, _tolerance(p, both))  # not that of a guess alone
        moved = np.abs(change) <= CLOSE * np.abs(both[free]) + np.finfo(float).tiny
        near_enough = np.all(np.abs(change) <= NEAR * tolerance[free])
        if found is None or (moved.all() and near_enough) or not f.any():
            if not near_enough and f.any():
                break
            near = np.concatenate([NEAR * tolerance[:n], ROUNDING * np.abs(both[n:])])
            if np.any(np.abs(f) > abs(jacobian) @ near + np.finfo(float).tiny):
                break
            return both
    wrong = np.flatnonzero(np.abs(f) > abs(equations.jacobian(both)) @ tolerance)
    raise ValueError(
        f"No consistent start was found with {held}: "
        f"{names('equation', wrong if wrong.size else np.arange(n))} of `F` "
        f"{'stays' if wrong.size == 1 else 'stay'} different from 0. Hold other numbers, or start "
        "nearer to a solution."
    )


def _change(jacobian, f, noise):
    """(Newton's change of the free numbers, the function that measures a residual).

    `noise` is the relative error of the Jacobian.
    """
    sparse = not isinstance(jacobian, np.ndarray)
    rows = abs(jacobian).max(axis=1)
    rows = rows.toarray().ravel() if sparse else rows
    rows = 1.0 / np.where(rows > 0.0, rows, 1.0)

    def size(residual):
        return float(np.linalg.norm(rows * residual))

    if sparse:
        from scipy.sparse import diags

        return _sparse_solution(diags(rows) @ jacobian, -rows * f), size
    return _full_solution(rows[:, None] * jacobian, -rows * f, noise), size


def solution(matrix, right, noise):
    """The shortest solution, (k, m), of a linear system with m right-hand sides."""
    if isinstance(matrix, np.ndarray):
        rows = np.abs(matrix).max(axis=1, initial=0.0)
        rows = 1.0 / np.where(rows > 0.0, rows, 1.0)[:, None]
        columns = np.transpose(_full_solution(rows * matrix, rows * right, noise))
    else:
        columns = [_sparse_solution(matrix, each) for each in right.T]
    return np.reshape(columns, (right.shape[1], matrix.shape[1])).T


def _sparse_solution(matrix, b):
    from scipy.sparse.linalg import lsqr, splu

    if matrix.shape[0] == matrix.shape[1]:
        try:
            return splu(matrix.tocsc()).solve(b)
        except RuntimeError:  # singular
            pass
    return lsqr(matrix, b, atol=1e-14, btol=1e-14)[0]


def _full_solution(matrix, b, noise):
    """The solution, or the shortest of the best approximations if there is no single one."""
    columns = np.abs(matrix).max(axis=0, initial=0.0)
    columns = 1.0 / np.where(columns > 0.0, columns, 1.0)
    scaled = matrix * columns
    if scaled.shape[0] == scaled.shape[1] and np.linalg.cond(scaled, 1) < 1.0 / noise:
        return (columns * np.linalg.solve(scaled, b).T).T
    return (columns * np.linalg.lstsq(scaled, b, rcond=noise)[0].T).T


def _line_search(equations, both, free, change, size):
    """([y, y'], F) behind a step that reduces F; None if no step does."""
    before = size(equations.residual(both))
    share = 1.0
    for _ in range(HALVINGS):
        trial = both.copy()
        trial[free] += share * change
        f = equations.residual(trial)
        if np.isfinite(f).all() and size(f) <= (1.0 - DESCENT * share) * before:
            return trial, f
        share *= 0.5
    return None
