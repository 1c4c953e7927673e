"""Equations with a mass matrix: the words for kernels, a consistent start, the first step."""

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.python_callback import evaluate
from fastdyn.kernels.calls.block import MASS, PLACES
from fastdyn.problem.mass import equilibrated

from .check_jacobian import evaluated

STEP = np.finfo(float).eps ** (1 / 3)
SINGULAR = 1e-9  # a smaller pivot is singular, with rows and columns scaled to size 1
ITERATIONS = 20
NOT_OF_INDEX_1 = (
    "With this `mass` the equations are no DAE of index 1 at the start: the algebraic ones do not "
    "determine the algebraic variables. Differentiate the constraints by hand until they do, or "
    "leave out what is said twice."
)


def mass_of(problem, bound):
    """The words of the mass matrix, named in the block of the equations; None without one."""
    words = None if problem.mass is None else _words(problem.mass)
    bound.block[MASS] = 0 if words is None else address_of(words)
    return words


def _words(matrix):
    """The words of a mass matrix: see `kernels/algebra/mass.py`."""
    columns, rows = np.nonzero(matrix.T)
    numbers = np.ascontiguousarray(matrix[rows, columns]).view(np.int64)
    far = rows - columns
    head = [len(rows), max(0, far.max(initial=0)), max(0, -far.min(initial=0))]
    assert len(head) == PLACES
    return np.concatenate([np.array(head, np.int64), columns * len(matrix) + rows, numbers])


def with_mass(problem, bound):
    """Check the start of a problem with a mass matrix, and choose the size of its first step."""
    p = problem

    def fun(y):
        if bound.function is None:
            return evaluate(bound.python, bound.mode, p.t0, y.copy())
        return evaluated(bound, p.t0, y, len(y))

    f = fun(p.y0)
    if not np.isfinite(f).all():
        return p  # the solve reports the failure
    _check_start(p, fun, f)
    if p.h > 0.0:
        return p
    scale = p.atol + p.rtol * np.abs(p.y0)
    mass, rows, columns = equilibrated(p.mass)
    rate = columns * np.linalg.lstsq(mass, rows * f, rcond=None)[0]
    size, slope = (np.sqrt(np.mean((x / scale) ** 2)) for x in (p.y0, rate))
    h = 1e-6 if min(size, slope) < 1e-5 else 0.01 * size / slope
    return p._replace(h=float(min(h, abs(p.tf - p.t0), p.h_max)))


def _check_start(problem, fun, f):
    """Raise ValueError if the start does not satisfy the algebraic equations."""
    p = problem
    mass, rows, columns = equilibrated(p.mass)
    left, sizes, right = np.linalg.svd(mass)
    rank = int(np.sum(sizes > len(f) * np.finfo(float).eps * sizes[0])) if sizes[0] else 0
    left, right = left[:, rank:].T * rows, columns[:, None] * right[rank:].T
    if not left.size:
        return

    def newton(y, f):
        x = _solution(left @ _jacobian(fun, y) @ right, -left @ f)
        return None if x is None else right @ x

    change = newton(p.y0, f)
    if change is None:
        raise ValueError(NOT_OF_INDEX_1)
    far = np.abs(change) / (p.atol + p.rtol * np.abs(p.y0))
    if far.max() > 1.0:
        raise ValueError(
            f"`y0` does not fulfil the algebraic equations, the rows where `mass` is singular: "
            f"component {np.argmax(far)} is off by {far.max():.2g} times its tolerance. "
            + _advice(_consistent(p.y0, change, newton, fun))
        )


def _advice(y):
    if y is None:
        return "Newton's iteration finds no state near it that does: start nearer to one."
    return f"Start from {y.tolist()}, where they hold."


def _consistent(y, change, newton, fun):
    """The limit of Newton's iteration from y; None if the iteration does not converge."""
    for _ in range(ITERATIONS):
        y = y + change
        f = fun(y)
        change = newton(y, f) if np.isfinite(f).all() else None
        if change is None:
            return None
        if np.abs(change).max() <= 1e-12 * np.abs(y).max():
            return y
    return None


def _solution(matrix, b):
    """x with matrix x = b; None if the matrix is singular in any units."""
    rows = np.abs(matrix).max(axis=1)
    if not (np.isfinite(rows).all() and rows.all()):
        return None
    scaled = matrix / rows[:, None]
    columns = np.abs(scaled).max(axis=0)
    if not columns.all() or np.linalg.svd(scaled / columns)[1].min() < SINGULAR:
        return None
    return np.linalg.solve(scaled / columns, b / rows) / columns


def _jacobian(fun, y):
    """The Jacobian by central differences, (n, n)."""
    columns, least = [], STEP * max(1e-3, float(np.median(np.abs(y))))
    for j, size in enumerate(np.abs(y)):
        ends = []
        for sign in (1.0, -1.0):
            moved = y.copy()
            moved[j] += sign * max(STEP * size, least)
            ends.append((moved[j], fun(moved)))
        (high, above), (low, below) = ends
        columns.append((above - below) / (high - low))
    return np.array(columns).T
