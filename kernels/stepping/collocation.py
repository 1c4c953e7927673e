"""Collocation of boundary value problems on a mesh: Newton's iteration, and residuals.

The formula is Lobatto IIIA of order 4.  The unknowns are the states y_0, ..., y_N of n numbers each
and k parameters p.  For the linear equations see `condensation.py`.

The constants and decisions of the iteration are those of `scipy.integrate.solve_bvp`.
"""

from typing import Any, NamedTuple

import numpy as np

from ..algebra.factorise import factorise
from ..calls.block import RAISED_WORD
from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from .condensation import copy_numbers, eliminate, solve_linearised

DONE, SINGULAR, RAISED = range(3)  # the results of kernels
MOST_JACOBIANS = 4
MOST_ITERATIONS = 8
MOST_TRIALS = 4
ARMIJO, SHORTER = 0.2, 0.5  # least improvement, and the factor of a shorter step


class Functions(NamedTuple):
    """Blocks of functions, and the tables of a singular term S y / (x - a), empty without it.

    `fun` takes [y, p]; `bc` takes [y_0, y_N, p]; their results are padded with zeros to the same
    lengths.  `jac` and `bc_jac` take these states, each followed by a unit matrix by rows, and give
    the values, followed by the derivatives.  `first` is the matrix of slopes at x = a, and `keeps`
    projects y_0.
    """

    fun: Any
    jac: Any
    bc: Any
    bc_jac: Any
    s: Any
    first: Any
    keeps: Any


class Mesh(NamedTuple):
    """Nodes x (m,), states y (m, n), parameters p (k,)."""

    x: Any
    y: Any
    p: Any


class Room(NamedTuple):
    """The numbers of an iteration; for the shapes see `fastdyn/solve/boundary/mesh.py`."""

    point: Any
    value: Any
    longer: Any
    longer_value: Any
    ends: Any
    conditions: Any
    longer_ends: Any
    longer_conditions: Any
    f: Any
    middle: Any
    f_middle: Any
    residuals: Any
    jac: Any
    jac_middle: Any
    rows: Any
    blocks: Any
    last: Any
    pivots: Any
    right: Any
    step: Any
    step_p: Any
    again: Any
    again_p: Any
    y_before: Any
    p_before: Any


@njit(**INTERNAL)
def _join_rows(y, p, target):
    n = len(y)
    for i in range(n):
        target[i] = y[i]
    for i in range(len(p)):
        target[n + i] = p[i]


@njit(**INTERNAL)
def _copy(y, p, y_target, p_target):
    for i in range(len(y)):
        copy_numbers(y[i], y_target[i])
    copy_numbers(p, p_target)


@njit(**INTERNAL)
def _slope(functions, a, x, y, p, room, f):
    """Put the slope at x into the row f; False if the function raised."""
    n = len(y)
    s = functions.s
    _join_rows(y, p, room.point)
    by_pointer(x, room.point, functions.fun, room.value)
    if functions.fun[RAISED_WORD] != 0:
        return False
    for i in range(n):
        f[i] = room.value[i]
    if len(s) == 0:
        return True
    for i in range(n):
        if x == a:
            f[i] = 0.0
        for j in range(n):
            f[i] += functions.first[i, j] * room.value[j] if x == a else s[i, j] * y[j] / (x - a)
    return True


@njit(**INTERNAL)
def _jacobian(functions, a, x, y, p, room, jac):
    """Put the derivatives of the slope by y and p into `jac`; False if the function raised."""
    n = len(y)
    size = len(y) + len(p)
    s = functions.s
    _join_rows(y, p, room.longer)
    by_pointer(x, room.longer, functions.jac, room.longer_value)
    if functions.jac[RAISED_WORD] != 0:
        return False
    found = room.longer_value
    for i in range(n):
        for j in range(size):
            jac[i, j] = found[(1 + i) * size + j]
    if len(s) == 0:
        return True
    for i in range(n):
        for j in range(size):
            if x == a:
                jac[i, j] = 0.0
                for q in range(n):
                    jac[i, j] += functions.first[i, q] * found[(1 + q) * size + j]
            elif j < n:
                jac[i, j] += s[i, j] / (x - a)
    return True


@njit(**INTERNAL)
def _collocate(functions, mesh, room):
    """Compute slopes, residuals and boundary conditions; False if a function raised."""
    x = mesh.x
    y = mesh.y
    p = mesh.p
    m, n = y.shape
    a = mesh.x[0]
    f = room.f
    for q in range(m):
        if not _slope(functions, a, x[q], y[q], p, room, f[q]):
            return False
    for q in range(m - 1):
        h = x[q + 1] - x[q]
        for i in range(n):
            bend = 0.125 * h * (f[q + 1, i] - f[q, i])
            room.middle[q, i] = 0.5 * (y[q + 1, i] + y[q, i]) - bend
        here = x[q] + 0.5 * h
        if not _slope(functions, a, here, room.middle[q], p, room, room.f_middle[q]):
            return False
        for i in range(n):
            total = f[q, i] + f[q + 1, i] + 4.0 * room.f_middle[q, i]
            room.residuals[q, i] = y[q + 1, i] - y[q, i] - h / 6.0 * total
    for i in range(n):
        room.ends[i], room.ends[n + i] = y[0, i], y[m - 1, i]
    for i in range(len(p)):
        room.ends[2 * n + i] = p[i]
    by_pointer(a, room.ends, functions.bc, room.conditions)
    return functions.bc[RAISED_WORD] == 0


@njit(**INTERNAL)
def _linearise(functions, mesh, room):
    """Compute [A_i, C_i, P_i] of all intervals; False if a function raised."""
    x = mesh.x
    y = mesh.y
    p = mesh.p
    rows = room.rows
    m, n = y.shape
    k = len(mesh.p)
    a = mesh.x[0]
    for q in range(m):
        if not _jacobian(functions, a, x[q], y[q], p, room, room.jac[q]):
            return False
    for q in range(m - 1):
        h = x[q + 1] - x[q]
        middle = room.jac_middle[q]
        left = room.jac[q]
        right = room.jac[q + 1]
        if not _jacobian(functions, a, x[q] + 0.5 * h, room.middle[q], p, room, middle):
            return False
        for i in range(n):
            for j in range(n):
                before = after = 0.0
                for c in range(n):
                    before += middle[i, c] * left[c, j]
                    after += middle[i, c] * right[c, j]
                one = 1.0 if i == j else 0.0
                rest = h / 6.0 * (left[i, j] + 2.0 * middle[i, j])
                rows[q, i, j] = -one - rest - h * h / 12.0 * before
                rest = h / 6.0 * (right[i, j] + 2.0 * middle[i, j])
                rows[q, i, n + j] = one - rest + h * h / 12.0 * after
            for j in range(n, n + k):
                total = 0.0
                for c in range(n):
                    total += middle[i, c] * (left[c, j] - right[c, j])
                total = 4.0 * (middle[i, j] + 0.125 * h * total) + left[i, j] + right[i, j]
                rows[q, i, n + j] = -h / 6.0 * total
    return True


@njit(**INTERNAL)
def _join(functions, mesh, room):
    """Factorise what is left of the intervals with the boundary conditions; DONE or a failure."""
    m, n = mesh.y.shape
    k = len(mesh.p)
    size = 2 * n + k
    last = room.last
    copy_numbers(room.ends, room.longer_ends)
    by_pointer(mesh.x[0], room.longer_ends, functions.bc_jac, room.longer_conditions)
    if functions.bc_jac[RAISED_WORD] != 0:
        return RAISED
    found = room.longer_conditions
    left = room.blocks[m - 2]
    for j in range(size):
        for i in range(n):
            last[j * size + i] = left[n + i, n + j]
        for i in range(n + k):
            last[j * size + n + i] = found[(1 + i) * size + j]
    factorise(last, size, room.pivots, size, size - 1, size - 1)
    for j in range(size):
        if not np.isfinite(last[j * size + j]):
            return SINGULAR
    return DONE


@njit(**INTERNAL)
def _square(y, p):
    total = 0.0
    for i in range(y.shape[0]):
        for j in range(y.shape[1]):
            total += y[i, j] * y[i, j]
    for j in range(len(p)):
        total += p[j] * p[j]
    return total


@njit(**INTERNAL)
def _step(functions, mesh, room, alpha):
    """Take `alpha` times the step from the point before, and collocate there."""
    y = mesh.y
    p = mesh.p
    n = mesh.y.shape[1]
    for i in range(len(y)):
        for j in range(n):
            y[i, j] = room.y_before[i, j] - alpha * room.step[i, j]
    for j in range(len(p)):
        p[j] = room.p_before[j] - alpha * room.step_p[j]
    if len(functions.keeps) > 0:
        for i in range(n):
            room.point[i] = 0.0
            for j in range(n):
                room.point[i] += functions.keeps[i, j] * y[0, j]
        for i in range(n):
            y[0, i] = room.point[i]
    return _collocate(functions, mesh, room)


@njit(**INTERNAL)
def _small(mesh, room, tol, bc_tol):
    """Whether residuals and boundary conditions are within the tolerances."""
    m, n = mesh.y.shape
    k = len(mesh.p)
    for q in range(m - 1):
        bound = 2.0 / 3.0 * (mesh.x[q + 1] - mesh.x[q]) * 5e-2 * tol
        for i in range(n):
            if not abs(room.residuals[q, i]) < bound * (1.0 + abs(room.f_middle[q, i])):
                return False
    for i in range(n + k):
        if not abs(room.conditions[i]) < bc_tol:
            return False
    return True


@njit(**INTERNAL)
def newton(functions, mesh, room, tol, bc_tol):
    """Iterate from the states and parameters of the mesh, which are replaced; DONE or a failure."""
    if not _collocate(functions, mesh, room):
        return RAISED
    n_jacobians = 0
    known = False
    cost = 0.0
    for _ in range(MOST_ITERATIONS):
        if not known:
            n_jacobians += 1
            if not _linearise(functions, mesh, room):
                return RAISED
            if not eliminate(room.rows, room.blocks):
                return SINGULAR
            status = _join(functions, mesh, room)
            if status != DONE:
                return status
            solve_linearised(room, room.step, room.step_p)
            cost = _square(room.step, room.step_p)
        _copy(mesh.y, mesh.p, room.y_before, room.p_before)
        alpha = 1.0
        cost_new = 0.0
        for trial in range(MOST_TRIALS + 1):
            if not _step(functions, mesh, room, alpha):
                return RAISED
            solve_linearised(room, room.again, room.again_p)
            cost_new = _square(room.again, room.again_p)
            if cost_new < (1.0 - 2.0 * alpha * ARMIJO) * cost:
                break
            if trial < MOST_TRIALS:
                alpha *= SHORTER
        if n_jacobians == MOST_JACOBIANS or _small(mesh, room, tol, bc_tol):
            break
        known = alpha == 1.0
        if known:
            _copy(room.again, room.again_p, room.step, room.step_p)
            cost = cost_new
    return DONE


@njit(**INTERNAL)
def rms_residuals(functions, mesh, room, rms):
    """The root mean squares of the relative residuals of the spline, by Lobatto's rule."""
    x = mesh.x
    y = mesh.y
    f = room.f
    n = mesh.y.shape[1]
    for q in range(len(x) - 1):
        h = x[q + 1] - x[q]
        total = 0.0
        for i in range(n):
            r = 1.5 * room.residuals[q, i] / h / (1.0 + abs(room.f_middle[q, i]))
            total += 32.0 / 45.0 * r * r
        for sign in (-1.0, 1.0):
            s = 0.5 * h + sign * 0.5 * h * np.sqrt(3.0 / 7.0)
            state = room.again[0]
            slope = room.again[1]
            for i in range(n):
                rise = (y[q + 1, i] - y[q, i]) / h
                bend = (f[q, i] + f[q + 1, i] - 2.0 * rise) / h
                curve = (rise - f[q, i]) / h - bend
                state[i] = y[q, i] + s * (f[q, i] + s * (curve + s * bend / h))
            if not _slope(functions, x[0], x[q] + s, state, mesh.p, room, slope):
                return RAISED
            for i in range(n):
                rise = (y[q + 1, i] - y[q, i]) / h
                bend = (f[q, i] + f[q + 1, i] - 2.0 * rise) / h
                curve = (rise - f[q, i]) / h - bend
                along = f[q, i] + s * (2.0 * curve + s * 3.0 * bend / h)
                r = (along - slope[i]) / (1.0 + abs(slope[i]))
                total += 49.0 / 90.0 * r * r
        rms[q] = np.sqrt(0.5 * total)
    return DONE
