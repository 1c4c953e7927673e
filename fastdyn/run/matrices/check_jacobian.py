"""Compares the user's Jacobian, or its pattern, with differences of `fun`.

Each pair of `fun` and Jacobian is compared once by each method.
"""

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile import memory
from fastdyn.compile.derivatives.jacobian_block import groups_of
from fastdyn.compile.derivatives.sparse_jacobian import is_sparse
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.python_callback import matrix as as_matrix
from fastdyn.compile.sentences import warn
from fastdyn.compile.traced.known import Attempt
from fastdyn.kernels.calls.block import RAISED_WORD
from fastdyn.specialise.scalar import evaluate_kernel

APART = 1e-2  # relative deviation of an element beyond the error of differences
NOISE = 1e3 * np.finfo(float).eps  # rounding of a difference, relative to its terms
STEP = np.finfo(float).eps ** (1 / 3)  # of central differences: rounding and formula err alike
MANY = 60  # above so many components, a product with a vector replaces the single elements

_checked = memory.Table()  # functions with their Jacobians or patterns


def check_jacobian(problem, bound, jacobian):
    """Warn if a Jacobian is not the derivative of the equations.

    If the function returns sparse matrices, or has many components, or runs in Python, a product
    with a vector is compared instead of the elements.  Python functions that may do more than give
    values are not called.
    """
    given = jacobian.held.fun
    compiled = jacobian.function
    sparse = jacobian.mode.entries or is_sparse(given)
    n = len(problem.y0)
    if bound.pair or _may_act(bound, n) or (not sparse and _may_act(jacobian, n)):
        return
    place = problem.method.name, compiled.key if compiled else id(given)
    if not _first_time(bound, place, given):
        return
    whole = sparse or bound.function is None or compiled is None or n > MANY
    for y, size in _states(problem):
        found = (_wrong_product if whole else _wrong_element)(bound, jacobian, problem.t0, y, size)
        if found:
            warn(
                f"`jac` is not the Jacobian of `fun`: {found} Correct it, or leave it out: a wrong "
                "one costs many steps."
            )
            return


def _may_act(bound, n):
    """Whether a function runs in Python and may do more than give a value."""
    if bound.mode.constant:
        return False
    held = bound.held
    return bound.function is None and Attempt(held.fun, held.args, bound.mode, n).may_act()


def check_sparsity(problem, bound, entries):
    """Warn if `jac_sparsity` lacks an element of the Jacobian of `fun`.

    If the `entries` of the exact Jacobian are not known, a product with a vector is compared.
    """
    p = problem
    n = len(problem.y0)
    given = p.sparsity.columns * n + p.sparsity.rows
    if entries is not None:
        missing = np.setdiff1d(entries.columns * n + entries.rows, given)
        found = f"element ({missing[0] % n}, {missing[0] // n})" if len(missing) else None
    elif bound.pair or not _first_time(bound, given.tobytes()):
        return
    else:
        found = _missing_row(p, bound)
    if found:
        warn(
            f"`jac_sparsity` is not the pattern of the Jacobian of `fun`: it lacks {found}. "
            "Correct it, or leave it out: a wrong one costs many steps."
        )


def _first_time(bound, other, held=None):
    """Whether a function and `other` are compared for the first time; `held` is kept alive."""
    function = bound.function
    fun = bound.held.fun
    place = (id(fun) if function is None else function.key), other
    if _checked.get(place):
        return False
    _checked.put(place, (fun, held, function))
    return True


def _states(problem):
    """The start and a displaced state, each with the sizes of its components."""
    p = problem
    size = np.maximum(np.abs(p.y0), 0.1 * max(1e-3, float(np.median(np.abs(p.y0)))))
    beside = p.y0 + 0.1 * size * np.random.default_rng(0).random(len(p.y0))
    return (p.y0, size), (beside, size)


def _wrong_element(bound, jacobian, t, y, size):
    """A sentence about the first wrong element; None if all are right."""
    given = evaluated(jacobian, t, y, len(y) ** 2).reshape(len(y), -1)
    near, far = (_differences(bound, t, y, size * step) for step in (STEP, 4 * STEP))
    doubt = 10 * np.abs(near[0] - far[0]) + near[1] + APART * np.abs(near[0])
    wrong = np.abs(given - near[0]) > doubt + APART * np.abs(given)
    if not wrong.any():
        return None
    i, j = np.argwhere(wrong)[0]
    return (
        f"at t = {t:.10g}, y = {_short(y)} its element ({i}, {j}) is {given[i, j]:.6g}, and `fun` "
        f"changes by {near[0][i, j]:.6g} with y[{j}]."
    )


def _short(y):
    """A state in a sentence: of many components the first and the last."""
    return np.array2string(y, precision=6, threshold=6, edgeitems=2, separator=", ")


def _wrong_product(bound, jacobian, t, y, size):
    """A sentence about the first wrong component of a product with a vector; None if all agree."""
    v = size * np.random.default_rng(1).uniform(0.5, 1.0, len(y))
    if jacobian.function is None or jacobian.mode.constant:
        matrix = jacobian.python(t, y)
        matrix = matrix if is_sparse(matrix) else as_matrix(np.atleast_2d(matrix), len(y))
    else:
        matrix = evaluated(jacobian, t, y, len(y) ** 2).reshape(len(y), -1)
    given = matrix @ v
    terms = abs(matrix) @ v
    near, far = (_difference(bound, t, y, v, step) for step in (STEP, 4 * STEP))
    doubt = 10 * np.abs(near[0] - far[0]) + near[1] + APART * terms
    (wrong,) = np.nonzero(np.abs(given - near[0]) > doubt)
    if not len(wrong):
        return None
    i = wrong[0]
    return (
        f"at t = {t:.10g}, row {i} times a vector is {given[i]:.6g}, and `fun` changes by "
        f"{near[0][i]:.6g} along it."
    )


def _missing_row(problem, bound):
    """The first row in which the grouped Jacobian times a vector differs from a difference."""
    p = problem
    n = len(problem.y0)
    y = problem.y0
    rows, columns = problem.sparsity
    rng = np.random.default_rng(1)
    size = _states(p)[0][1]
    v, w = size * rng.uniform(0.5, 1.0, (2, n))
    group = groups_of(p.sparsity, n)
    total = np.zeros(n)
    doubt = np.zeros(n)
    for g in range(group.max(initial=-1) + 1):
        change, noise = _difference(bound, p.t0, y, np.where(group == g, v, 0.0), STEP)
        mine = group[columns] == g
        row = rows[mine]
        times = (w / v)[columns[mine]]
        np.add.at(total, row, change[row] * times)
        np.add.at(doubt, row, (noise[row] + APART * np.abs(change[row])) * times)
    near, far = (_difference(bound, p.t0, y, w, step) for step in (STEP, 4 * STEP))
    doubt += 10 * np.abs(near[0] - far[0]) + near[1]
    (wrong,) = np.nonzero(np.abs(near[0] - total) > doubt)
    return f"an element of row {wrong[0]}" if len(wrong) else None


def evaluated(bound, t, y, size):
    """The value of a compiled function; NaN if the function raised."""
    if bound.mode.constant:
        return bound.python(t, y).reshape(-1)
    out = np.full(size, np.nan)
    Call(evaluate_kernel(), bound.block, t, np.ascontiguousarray(y), out)()
    if bound.block[RAISED_WORD]:
        bound.block[RAISED_WORD] = 0
        out[:] = np.nan
    return out


def _difference(bound, t, y, v, step):
    """The derivative of the function along v, and a bound of its rounding error."""
    ends = [_value(bound, t, y + sign * step * v) for sign in (1, -1)]
    noise = NOISE * (np.abs(ends[0]) + np.abs(ends[1])) / (2 * step)
    return (ends[0] - ends[1]) / (2 * step), noise


def _value(bound, t, y):
    if bound.function is None:
        return evaluate(bound.python, bound.mode, t, y)
    return evaluated(bound, t, y, len(y))


def _differences(bound, t, y, steps):
    """Central differences, (n, n), and a bound of their rounding error."""
    columns = []
    noise = []
    for j, h in enumerate(steps):
        ends = []
        for sign in (1, -1):
            moved = y.copy()
            moved[j] += sign * h
            ends.append((moved[j], evaluated(bound, t, moved, len(y))))
        (right, above), (left, below) = ends
        columns.append((above - below) / (right - left))
        noise.append(NOISE * (np.abs(above) + np.abs(below)) / (right - left))
    return np.array(columns).T, np.array(noise).T
