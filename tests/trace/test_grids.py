"""Maps of several variables: on the grid, between, at the edges, outside, of no number."""

import itertools
import warnings

import numpy as np
import pytest
import scipy.integrate
from scipy import interpolate

import fastdyn
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace

X = np.array([-1.0, -0.4, 0.1, 0.5, 1.2, 1.9, 2.0])
Y = np.linspace(0.0, 2.0, 6)
Z = np.array([0.0, 0.3, 1.0, 1.5])
PLANE = np.sin(3 * X)[:, None] * np.cos(2 * Y) + X[:, None] * Y
SPACE = PLANE[..., None] * np.exp(Z)


def places(rng, *grids):
    """Places on the grid, beside, between, at the edges, outside, of no number."""
    each = [
        np.concatenate([
            x, np.nextafter(x, 9), np.nextafter(x, -9), rng.uniform(x[0] - 0.3, x[-1] + 0.3, 20),
            [x[0] - 3, x[-1] + 3, np.nan, np.inf, -np.inf],
        ])
        for x in grids
    ]  # fmt: skip
    together = np.array([rng.permutation(np.resize(x, 200)) for x in each])
    corners = np.array(list(itertools.product(*[(x[0], x[-1]) for x in grids]))).T
    return np.concatenate([together, corners], axis=1)


def agrees(fun, at):
    """The graph beside the function, exceptions included; infinite places may be Python's."""

    def of_state(t, y):
        return np.ravel(fun(*y))

    middle = np.nanmedian(at, axis=1)
    found = trace(of_state, (), len(at), (len(of_state(0.0, middle)),))
    values = found.graph.values
    t = np.zeros(at.shape[1])
    mine, raises = evaluate(found.graph, found.outputs, t, at, values, [found.raising])
    n_compared = 0
    for j, y in enumerate(at.T):
        if np.isinf(y).any() and raises[0, j]:
            continue
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                theirs = of_state(0.0, y)
        except ValueError:
            assert raises[0, j], y
            continue
        assert not raises[0, j], y
        np.testing.assert_allclose(mine[:, j], theirs, 1e-11, 1e-11, err_msg=str(y))
        n_compared += 1
    return n_compared


@pytest.mark.few(4)
@pytest.mark.parametrize("method", ["linear", "nearest", "slinear", "cubic", "quintic"])
@pytest.mark.parametrize("fill", ["raise", "nan", "number", "go on"])
def test_regular_grids(method, fill):
    options = {
        "raise": {}, "nan": {"bounds_error": False},
        "number": {"bounds_error": False, "fill_value": 2.5},
        "go on": {"bounds_error": False, "fill_value": None},
    }[fill]  # fmt: skip
    rng = np.random.default_rng(1)
    table = interpolate.RegularGridInterpolator((X, Y), PLANE, method, **options)
    at = places(rng, X, Y)
    assert agrees(lambda x, y: table((x, y)), at) > 50
    agrees(lambda x, y: table([[x, y], [y, x]]), at)
    agrees(lambda x, y: table(np.array([x, y]))[0], at)
    down = interpolate.RegularGridInterpolator((X[::-1], Y), PLANE[::-1], method, **options)
    agrees(lambda x, y: down((np.array([x, 0.2]), y)), at)
    rows = np.stack([PLANE, PLANE**2], axis=-1)
    pairs = interpolate.RegularGridInterpolator((X, Y), rows, method, **options)
    agrees(lambda x, y: pairs([[x, y]]), at)
    if method in ("linear", "nearest"):
        space = interpolate.RegularGridInterpolator((X, Y, Z), SPACE, method, **options)
        agrees(lambda x, y, z: space([x, y, z]), places(rng, X, Y, Z))
        agrees(lambda x, y: interpolate.interpn((X, Y), PLANE, (x, y), method, **options), at)
    elif method != "slinear":
        agrees(lambda x, y: table((x, y), nu=(1, 0)), at)


@pytest.mark.parametrize("kx, ky", [(3, 3), (1, 1), (2, 4), (5, 3), (1, 3)])
def test_splines_of_two_variables(kx, ky):
    surface = interpolate.RectBivariateSpline(X, Y, PLANE, kx=kx, ky=ky)
    at = places(np.random.default_rng(2), X, Y)
    agrees(lambda x, y: surface.ev(x, y), at)
    agrees(lambda x, y: surface(x, y), at)
    agrees(lambda x, y: surface(x, [y], grid=False), at)
    agrees(lambda x, y: surface.ev(np.array([x, y]), 0.7), at)
    if kx > 1:
        agrees(lambda x, y: surface.ev(x, y, dx=1), at)
        slope = surface.partial_derivative(1, 0)
        agrees(lambda x, y: slope(x, y), at)
    noisy = interpolate.SmoothBivariateSpline(
        *np.random.default_rng(3).uniform(0, 1, (3, 80)), kx=kx, ky=ky, s=100.0
    )
    agrees(lambda x, y: noisy.ev(x, y), at)


def test_what_has_no_formula_is_refused():
    surface = interpolate.RectBivariateSpline(X, Y, PLANE)
    with pytest.raises(Untraceable, match="all pairs of two rows"):
        trace(lambda t, y: surface([y[0], y[0] + 1], y[1])[:, 0], (), 2, (2,))
    table = interpolate.RegularGridInterpolator((X, Y), PLANE, "pchip")
    with pytest.raises(Untraceable, match="RegularGridInterpolator"):
        trace(lambda t, y: table((y[0], y[1])), (), 2, (1,))


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_a_solve_follows_a_map_that_changes():
    speeds, throttles = np.linspace(0.0, 600.0, 13), np.linspace(0.0, 1.0, 7)
    torque = interpolate.RegularGridInterpolator(
        (speeds, throttles),
        80 - 0.1 * speeds[:, None] + np.outer(speeds, throttles) / 5,
        bounds_error=False,
        fill_value=None,
    )  # first without kinks, at which a rounding error changes the steps

    def engine(t, y):
        return [(torque((y[0], 0.5 + 0.4 * np.sin(t)))[()] - 0.3 * y[0]) / 0.2]

    def from_arrays(t, y):
        place = y[0], 0.5 + 0.4 * np.sin(t)
        found = interpolate.interpn((speeds, throttles), table, place, bounds_error=False)
        return [(found[()] - 0.3 * y[0]) / 0.2]

    table = torque.values.copy()
    for _ in range(3):
        for fun in (engine, from_arrays):
            theirs = scipy.integrate.solve_ivp(fun, (0, 5), [100.0], rtol=1e-6)
            mine = fastdyn.solve_ivp(fun, (0, 5), [100.0], rtol=1e-6)
            assert mine.nfev == theirs.nfev
            np.testing.assert_allclose(mine.y, theirs.y, 1e-6)
        torque.values[:] *= 1.02
        table *= 0.9
        speeds[6] += 1.0
