"""solve_bvp: boundary value problems with compiled functions, Jacobians and elimination."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import integrate
from scipy.optimize import OptimizeResult

from fastdyn.compile.compare import Different
from fastdyn.compile.sentences import GaveUp, Uncompilable, warn_once
from fastdyn.kernels.stepping import collocation
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.raised import explain

from .functions import differ, of_columns, of_ends
from .mesh import RaisedOnMesh, Solved, finer

EPS = np.finfo(float).eps
MOST_MESHES = 10
MESSAGES = (
    "The algorithm converged to the desired accuracy.",
    "The maximum number of mesh nodes is exceeded.",
    "A singular Jacobian encountered when solving the collocation system.",
    "The solver was unable to satisfy boundary conditions tolerance on iteration 10.",
)


class BVPResult(OptimizeResult):
    """The result of `solve_bvp`: SciPy's fields."""


OF_BVP: dict[str, Any] = {
    "fun": kinds.function_of("(x, y)"), "bc": kinds.function_of("(ya, yb)"), "x": kinds.numbers,
    "y": kinds.array, "p": kinds.array, "S": kinds.array, "fun_jac": kinds.function_of("(x, y)"),
    "bc_jac": kinds.function_of("(ya, yb)"), "tol": kinds.number, "max_nodes": kinds.number,
    "bc_tol": kinds.number,
}  # fmt: skip


@shown_when_wrong(**OF_BVP)
def solve_bvp(
    fun: Any,
    bc: Any,
    x: Any,
    y: Any,
    p: Any = None,
    S: Any = None,
    fun_jac: Any = None,
    bc_jac: Any = None,
    tol: float = 1e-3,
    max_nodes: int = 1000,
    verbose: int = 0,
    bc_tol: float | None = None,
) -> Any:
    """Solve y' = fun(x, y, p) + S y / (x - a) with bc(y(a), y(b), p) = 0, with compiled code.

    The arguments, results, messages and decisions are those of `scipy.integrate.solve_bvp`: meshes
    and solutions are equal up to rounding and the errors of SciPy's differences.

    Parameters
    ----------
    fun : callable
        ``fun(x, y)`` or ``fun(x, y, p)``, vectorised as SciPy's: x of shape (m,), y and the result
        of shape (n, m).  A column of the result must depend on the same column of y alone.
    bc : callable
        ``bc(ya, yb)`` or ``bc(ya, yb, p)`` returns n + k residuals.
    x, y : array_like, shape (m,), (n, m)
        The initial mesh, and the guess of the solution there.
    p : array_like, shape (k,), optional
        The guess of unknown parameters.
    S : array_like, shape (n, n), optional
        The matrix of a singular term.
    fun_jac, bc_jac : callable, optional
        Jacobians in SciPy's form.  By default they are the exact derivatives of `fun` and `bc`.
    tol, max_nodes, verbose, bc_tol
        As SciPy's: the tolerance of relative residuals, the most nodes of a mesh, what is printed,
        and the tolerance of the boundary conditions.

    Returns
    -------
    BVPResult
        SciPy's fields: `sol`, `p`, `x`, `y`, `yp`, `rms_residuals`, `niter`, `status`, `message`,
        `success`.

    Raises
    ------
    ValueError
        As SciPy: for wrong shapes, and a mesh that does not increase.

    Notes
    -----
    Complex problems, given Jacobians, and functions that cannot be traced and differentiated (with
    one CompileWarning) are solved by SciPy, which calls the functions in Python.

    Examples
    --------
    >>> mesh = np.linspace(0, 1, 5)
    >>> bratu = solve_bvp(
    ...     lambda x, y: np.vstack((y[1], -np.exp(y[0]))),
    ...     lambda ya, yb: np.array([ya[0], yb[0]]), mesh, np.zeros((2, 5)),
    ... )
    >>> round(float(bratu.sol(0.5)[0]), 3)
    0.141
    """
    for name, value in (("tol", tol), ("bc_tol", bc_tol)):
        if value is not None and not value >= 0:
            raise ValueError(f"`{name}` must not be negative; got {value}.")
    given = fun, bc, x, y, p, S, fun_jac, bc_jac, tol, max_nodes, verbose, bc_tol
    try:
        problem = None
        if fun_jac is None and bc_jac is None and verbose in (0, 1, 2) and tol >= 100 * EPS:
            problem = Problem.of(fun, bc, x, y, p, S)
        if problem is not None:
            return _solved(problem, tol, max_nodes, verbose, tol if bc_tol is None else bc_tol)
    except (Uncompilable, GaveUp, Different) as reason:
        warn_once(fun, str(reason))
    except RaisedOnMesh:  # SciPy's solver tells what
        pass
    return integrate.solve_bvp(*given)  # it refuses, too


class Problem:
    """A problem whose functions are compiled: `x`, `y` and `p` are the mesh and the guesses."""

    def __init__(self, fun, bc, x, y, p, S):
        self.fun = fun
        self.bc = bc
        self.x = x
        self.y = y
        self.p = p
        of_bc = of_ends(bc, y[:, 0], y[:, -1], p)
        self._bounds = (*of_columns(fun, x, y, p), *of_bc)  # their code and blocks are kept alive
        tables = [np.empty((0, 0))] * 3
        if S is not None:
            unit = np.eye(len(y))
            tables = [S, np.linalg.pinv(unit - S), unit - np.linalg.pinv(S) @ S]
            self.y = y = y.copy()
            y[:, 0] = tables[2] @ y[:, 0]
        tables = [np.ascontiguousarray(table) for table in tables]
        self.functions = collocation.Functions(*[bound.block for bound in self._bounds], *tables)

    @classmethod
    def of(cls, fun, bc, x, y, p, S):
        """The Problem of arguments; None for what SciPy refuses, and for complex numbers."""
        try:
            x = np.array(x, float)
            y = np.asarray(y)
            p = np.array([]) if p is None else np.asarray(p)
            S = np.zeros((0, 0)) if S is None else np.asarray(S)
        except (TypeError, ValueError):
            return None
        real = all(each.dtype.kind in "iuf" for each in (y, p, S))
        if not real or (x.ndim, y.ndim, p.ndim) != (1, 2, 1):
            return None
        y = y.astype(float)
        p = p.astype(float)
        S = S.astype(float)
        n, m = y.shape
        k = len(p)
        if not n or m < 2 or len(x) != m or not (np.diff(x) > 0).all():
            return None
        if S.size and S.shape != (n, n):
            return None
        args = (p,) if k else ()
        if np.shape(_called(fun, "`fun`", "fun(x, y)", x, y, args)) != y.shape:
            return None
        if np.shape(_called(bc, "`bc`", "bc(ya, yb)", y[:, 0], y[:, -1], args)) != (n + k,):
            return None
        return cls(fun, bc, x, y, p, S if S.size else None)

    def compare(self, found):
        """Raise Uncompilable if a Solved has other values than the functions in Python."""
        x = found.x
        y = found.y.copy()
        p = found.p.copy()
        args = (p,) if len(p) else ()
        real = np.asarray(self.fun(x, y.copy(), *args), float)
        if real.shape == y.shape and len(self.functions.s):
            real[:, 0] = self.functions.first @ real[:, 0]
            real[:, 1:] += self.functions.s @ y[:, 1:] / (x[1:] - x[0])
        of_bc = np.asarray(self.bc(y[:, 0].copy(), y[:, -1].copy(), *args), float)
        if real.shape != y.shape or differ(found.f, real) or differ(found.bc[None], of_bc[None]):
            raise Uncompilable("its compiled code gives other numbers than Python on the mesh")


def _called(function, who, form, one, other, args):
    """The value of `fun` or `bc`; an exception gets its note."""
    try:
        found = function(one, other, *args)
        np.shape(found)
        return found
    except Exception as error:
        if "inhomogeneous" in str(error):
            rows = "rows of one length: a constant in a row is 0 * x + c"
            must = rows if who == "`fun`" else "a row of numbers, one for each condition"
            error.add_note(f"{who} is called as {form} and must return {must}.")
        form = f"{form[:-1]}, p)" if args else form
        explain(error, who, form, one, other, function, args)
        raise


def _solved(problem, tol, max_nodes, verbose, bc_tol):
    """The BVPResult; the mesh is refined until the residuals are within the tolerance."""
    x = problem.x
    y = problem.y
    p = problem.p
    n_meshes = 0
    if verbose == 2:
        print(("{:^15}" * 5).format(*HEADER))
    while True:
        found = Solved(problem.functions, x, y, p, tol, bc_tol)
        n_meshes += 1
        y = found.y
        p = found.p
        rms = found.rms
        problem.compare(found)
        largest = rms.max()
        of_bc = np.abs(found.bc).max()
        if found.singular:
            status = 2
            break
        once = np.flatnonzero((rms > tol) & (rms < 100 * tol))
        twice = np.flatnonzero(rms >= 100 * tol)
        added = len(once) + 2 * len(twice)
        full = len(x) + added > max_nodes
        if verbose == 2:
            shown = f"({added})" if full else added
            print(f"{n_meshes:^15}{largest:^15.2e}{of_bc:^15.2e}{len(x):^15}{shown:^15}")
        if full:
            status = 1
            break
        if added:
            x = finer(x, once, twice)
            y = found.sol(x)
        elif of_bc <= bc_tol:
            status = 0
            break
        elif n_meshes >= MOST_MESHES:
            status = 3
            break
    if verbose:
        print(
            f"{SAID[status].format(n_meshes, len(x))} \nMaximum relative residual: {largest:.2e} \n"
            f"Maximum boundary residual: {of_bc:.2e}"
        )
    return BVPResult(
        sol=found.sol, p=p if len(p) else None, x=x, y=y, yp=found.f, rms_residuals=rms,
        niter=n_meshes, status=status, message=MESSAGES[status], success=status == 0,
    )  # fmt: skip


HEADER = "Iteration", "Max residual", "Max BC residual", "Total nodes", "Nodes added"
SAID = (
    "Solved in {} iterations, number of nodes {}.",
    "Number of nodes is exceeded after iteration {}.",
    "Singular Jacobian encountered when solving the collocation system on iteration {}.",
    "The solver was unable to satisfy boundary conditions tolerance on iteration {}.",
)
