"""Drift and diffusion are what Python says they are: functions of `tests/hostile`, changed between.

The reference is Euler and Maruyama's step in NumPy, with the Brownian motion of the solve.
"""

import contextlib
import io
import warnings

import numpy as np
import pytest
from hostile.compose import draw_case
from hostile.solving import loaded

from fastdyn import solve_sde

SEED, COUNT = 60, 48
STEPS, SPAN = 24, (0.3, 2.1)


def by_numpy(drift, diffusion, y0, w, args, extra):
    """The end of Euler and Maruyama's steps, w of shape (n, STEPS + 1), after more calls."""
    y, h = np.array(y0, float), (SPAN[1] - SPAN[0]) / STEPS
    for _ in range(extra):
        drift(SPAN[0], y.copy(), *args)
        diffusion(SPAN[0], y.copy(), *args)
    for i in range(STEPS):
        t = SPAN[0] + i * h
        a = np.asarray(drift(t, y.copy(), *args), float)
        g = np.asarray(diffusion(t, y.copy(), *args), float)
        y = y + h * a + g * (w[:, i + 1] - w[:, i])
    return y


def quiet(t, y, *args):
    return 0.05 * y - 0.1


def solved(module, role, again, extra):
    """The ends of three solves with changes between, by solve_sde, or by NumPy from its motions."""
    y0 = np.array(module.HOW["y0"], float)
    args = tuple(getattr(module, "args", ()))
    functions = (module.fun, quiet) if role == "drift" else (quiet, module.fun)
    for j in range(3):
        if j:
            module.change(j)
        if again is None:
            found = solve_sde(
                *functions, SPAN, y0, step=(SPAN[1] - SPAN[0]) / STEPS, rng=j, args=args,
                method="EulerMaruyama",
            )  # fmt: skip
            yield found.y[:, -1], found.brownian()
        else:
            yield by_numpy(*functions, y0, again[j], args, extra), None


def outcome(source, role, again=None, extra=0):
    """(ends, motions, exception): what a user sees."""
    ends, motions = [], []
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            for end, w in solved(loaded(source, "drawn"), role, again, extra):
                ends.append(end)
                motions.append(w)
    except Exception as error:
        return ends, motions, error
    return ends, motions, None


@pytest.mark.few(4)
@pytest.mark.parametrize("role", ["drift", "diffusion"])
@pytest.mark.parametrize("index", range(COUNT))
def test_a_hostile_function_has_numpys_paths(index, role):
    case = draw_case(SEED, index, light=True)
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        ends, motions, error = outcome(case.source, role)
        expected, _, other = outcome(case.source, role, motions)
        more, _, _ = outcome(case.source, role, motions, 1)
    if not np.array_equal(expected, more):
        return  # the value depends on the number of calls
    assert (error is None) == (other is None), (case.source, error, other)
    for end, exact in zip(ends, expected, strict=True):
        np.testing.assert_allclose(end, exact, rtol=1e-9, atol=1e-9, err_msg=case.source)
