"""The mass matrix: M(t, y) y' = f(t, y), solved for y' at each evaluation."""

import inspect

import numpy as np

from fastdyn.kernels.algebra.linear import SingularMatrixError

SINGULAR = (
    "Mass is singular at the start, and {} solves no algebraic equations; ode15s and ode23t do, if "
    "Mass is constant."
)


def with_mass(solver, fun, options, t0, y0):
    """The function of (t, y) that returns M \\ f, and None; or `fun` and a singular matrix M."""
    mass = options["Mass"]
    dependence = options.get("MStateDependence")
    try:
        return _divided(fun, mass, dependence, t0, y0), None
    except SingularMatrixError as error:
        if callable(mass) or not solver.algebraic:
            raise SingularMatrixError(SINGULAR.format(solver.name)) from error
    return fun, _matrix(mass, len(y0), regular=False)


def _divided(fun, mass, dependence, t0, y0):
    """
    The function of (t, y) that returns M \\ f.

    Parameters
    ----------
    fun : callable
    mass : array_like, shape (n, n), or callable
        A matrix, full or sparse, or a function of (t, y) or t. By default the signature tells
        whether the function takes y; see `dependence`.
    dependence : str or None
        MATLAB's MStateDependence: "none" for ``mass(t)``, "weak" or "strong" for ``mass(t, y)``.
    """
    if dependence is not None and dependence not in ("none", "weak", "strong"):
        raise ValueError(f"MStateDependence is 'none', 'weak' or 'strong'; got {dependence!r}.")
    if not callable(mass):
        matrix = _matrix(mass, len(y0))

        def constant(t, y):
            return np.linalg.solve(matrix, np.array(fun(t, y)))

        return constant
    by_time = dependence == "none" if dependence else _parameters(mass) == 1
    _matrix(mass(t0) if by_time else mass(t0, y0.copy()), len(y0))
    if by_time:

        def of_time(t, y):
            return np.linalg.solve(np.array(mass(t)), np.array(fun(t, y)))

        return of_time

    def of_state(t, y):
        return np.linalg.solve(np.array(mass(t, y)), np.array(fun(t, y)))

    return of_state


def _parameters(function):
    """The number of arguments that a function takes; 2 if the number is unknown."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return 2
    return sum(p.default is p.empty and p.kind != p.VAR_KEYWORD for p in parameters)


def _matrix(mass, n, regular=True):
    """A full matrix of n rows."""
    full = np.array(mass.toarray() if hasattr(mass, "toarray") else mass, float)
    if full.shape != (n, n):
        raise ValueError(f"Mass must be a matrix of shape {(n, n)}; got {full.shape}.")
    if not np.isfinite(full).all() or (regular and np.linalg.matrix_rank(full) < n):
        raise SingularMatrixError("Mass is singular")
    return full
