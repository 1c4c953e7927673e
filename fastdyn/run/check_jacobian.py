"""A Jacobian of the user beside differences of his function, once for each pair of functions."""

import warnings

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile.diagnostics import levels_inside
from fastdyn.compile.jacobian_block import CONSTANT
from fastdyn.kernels.calls.block import RAISED_WORD
from fastdyn.specialise.scalar import evaluate_kernel

APART = 1e-2  # of an element: what no difference is wrong by
NOISE = 1e3 * np.finfo(float).eps  # of what is subtracted
STEP = np.finfo(float).eps ** (1 / 3)

_checked: set = set()


def check_jacobian(problem, bound, jacobian):
    """Warn of a Jacobian that is not that of the equations, if both are compiled."""
    if bound.function is None or jacobian.function is None or bound.pair:
        return
    place = (bound.function.key or bound.function.address, jacobian.function.key)
    if place in _checked:
        return
    _checked.add(place)
    p = problem
    size = np.maximum(np.abs(p.y0), 0.1 * max(1e-3, float(np.median(np.abs(p.y0)))))
    beside = p.y0 + 0.1 * size * np.random.default_rng(0).random(len(p.y0))
    for y in (p.y0, beside):
        given = evaluated(jacobian, p.t0, y, len(y) ** 2).reshape(len(y), -1)
        near, far = (_differences(bound, p.t0, y, size * step) for step in (STEP, 4 * STEP))
        doubt = 10 * np.abs(near[0] - far[0]) + near[1] + APART * np.abs(near[0])
        wrong = np.abs(given - near[0]) > doubt + APART * np.abs(given)
        if wrong.any():
            i, j = np.argwhere(wrong)[0]
            warnings.warn(
                f"`jac` is not the Jacobian of `fun`: at t = {p.t0:.10g}, y = {y.tolist()} its "
                f"element ({i}, {j}) is {given[i, j]:.6g}, and `fun` changes by {near[0][i, j]:.6g}"
                f" with y[{j}]. Correct it, or leave it out: a wrong one costs many steps.",
                stacklevel=levels_inside(),
            )
            return


def evaluated(bound, t, y, size):
    """The numbers of a compiled function; NaN where it raised."""
    if bound.mode == CONSTANT:
        return bound.python(t, y).reshape(-1)
    out = np.full(size, np.nan)
    Call(evaluate_kernel(), bound.block, t, np.ascontiguousarray(y), out)()
    if bound.block[RAISED_WORD]:
        bound.block[RAISED_WORD] = 0
        out[:] = np.nan
    return out


def _differences(bound, t, y, steps):
    """Central differences, (n, n), and what rounding may have done to them."""
    columns, noise = [], []
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
