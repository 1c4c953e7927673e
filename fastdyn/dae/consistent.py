"""A consistent start of F(t, y, y') = 0, by Newton's iteration with a line search.

P. N. Brown, A. C. Hindmarsh and L. R. Petzold, "Consistent initial condition calculation for
differential-algebraic systems", SIAM J. Sci. Comput. 19 (1998).
"""

import numpy as np

from .equations import DENSE
from .index import check_index, check_structure, names

ITERATIONS, HALVINGS = 100, 40
DESCENT = 1e-4  # the share of the linear decrease that a step must reach
CLOSE = 1e-10  # of the last change, relative to the numbers
NEAR = 1e-3  # of the last change, in units of the tolerance, where rounding stops the iteration


def consistent(equations, problem, given):
    """[y, y'] with F = 0, from the start of a problem; ValueError without."""
    p, n, both = problem, equations.n, problem.y0
    jacobian, rates = equations.jacobian(both), equations.rates(both)
    if not rates.any():
        raise ValueError(
            "`F` does not depend on `yp`: its equations are algebraic, without an initial value "
            "problem; scipy.optimize.root solves them at each time."
        )
    if equations.pattern is not None:
        check_structure(equations.pattern, n)
    if n <= DENSE and np.isfinite(jacobian).all():
        check_index(jacobian, n, equations.noise)
    if given is None:
        _check(equations, p, jacobian)
        return both
    free = _free(given, rates)
    return _newton(equations, p, both, free, given)


def _free(given, rates):
    """The numbers of [y, y'] that may change."""
    if not isinstance(given, str):
        return ~given
    none, all_ = np.zeros_like(rates), np.ones_like(rates)
    halves = {"differential": (~rates, rates), "y": (none, rates), "yp": (all_, none)}
    return np.concatenate(halves[given])


def _tolerance(p):
    """What the numbers of [y, y'] may be off by."""
    return p.atol + p.rtol * np.abs(p.y0)


def _check(equations, p, jacobian):
    """Raise ValueError if F is not 0 at the start to within the tolerance of its unknowns."""
    off = np.abs(equations.residual(p.y0))
    allowed = abs(jacobian) @ _tolerance(p)
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
    both, n, tolerance = both.copy(), equations.n, _tolerance(p)
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
        change, size = _change(jacobian[:, free], f)
        found = _line_search(equations, both, free, change, size)
        if found is not None:
            both, f = found
        moved = np.abs(change) <= CLOSE * np.abs(both[free]) + np.finfo(float).tiny
        if found is None or moved.all() or not f.any():
            if not np.all(np.abs(change) <= NEAR * tolerance[free]) and f.any():
                break
            off = np.abs(f) > abs(jacobian) @ (NEAR * tolerance) + np.finfo(float).tiny
            if off.any():
                break
            return both
    wrong = np.flatnonzero(np.abs(f) > abs(equations.jacobian(both)) @ tolerance)
    raise ValueError(
        f"No consistent start was found with {held}: "
        f"{names('equation', wrong if wrong.size else np.arange(n))} of `F` "
        f"{'stays' if wrong.size == 1 else 'stay'} different from 0. Hold other numbers, or start "
        "nearer to a solution."
    )


def _change(jacobian, f):
    """(Newton's change of the free numbers, the function that measures a residual)."""
    rows = np.asarray(abs(jacobian).max(axis=1).todense()).ravel() if not isinstance(
        jacobian, np.ndarray
    ) else np.abs(jacobian).max(axis=1, initial=0.0)  # fmt: skip
    rows = 1.0 / np.where(rows > 0.0, rows, 1.0)

    def size(residual):
        return float(np.linalg.norm(rows * residual))

    if not isinstance(jacobian, np.ndarray):
        from scipy.sparse import diags
        from scipy.sparse.linalg import lsqr, splu

        matrix = diags(rows) @ jacobian
        if matrix.shape[0] == matrix.shape[1]:
            try:
                return splu(matrix.tocsc()).solve(-rows * f), size
            except RuntimeError:  # singular
                pass
        return lsqr(matrix, -rows * f, atol=1e-14, btol=1e-14)[0], size
    matrix = rows[:, None] * jacobian
    columns = np.abs(matrix).max(axis=0, initial=0.0)
    columns = 1.0 / np.where(columns > 0.0, columns, 1.0)
    return columns * np.linalg.lstsq(matrix * columns, -rows * f, rcond=None)[0], size


def _line_search(equations, both, free, change, size):
    """([y, y'], F) behind a step that reduces F; None if no step does."""
    before, share = size(equations.residual(both)), 1.0
    for _ in range(HALVINGS):
        trial = both.copy()
        trial[free] += share * change
        f = equations.residual(trial)
        if np.isfinite(f).all() and size(f) <= (1.0 - DESCENT * share) * before:
            return trial, f
        share *= 0.5
    return None
