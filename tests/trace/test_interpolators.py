"""Every interpolator: inside, at knots, at both ends, outside, of no number, and never stale."""

import warnings
from typing import Any

import numpy as np
import pytest
import scipy
from scipy import interpolate
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace

SCIPY = tuple(map(int, scipy.__version__.split(".")[:2]))
N = 9
KINDS = ["linear", "nearest", "nearest-up", "zero", "slinear", "quadratic", "cubic", 4]
KINDS += ["previous", "next"]
ENDS = {
    "nan": np.nan, "number": 3.5, "pair": (1.0, 2.0), "go on": "extrapolate",
    "half": (np.nan, 2.0), "columns": ([1.0, 5.0], [2.0, 3.0]),
}  # fmt: skip


def drawn(rng, n=N):
    return np.sort(rng.normal(size=n)), rng.normal(size=n)


def agrees(fun, points, name: Any = ""):
    """The graph beside the function, exceptions included; infinite numbers may be Python's."""

    def of_state(t, y):
        return np.ravel(fun(y[0]))

    size = len(of_state(0.0, [float(np.nanmedian(points))]))
    found = trace(of_state, (), 1, (size,))
    t, values = np.zeros_like(points), found.graph.values
    mine, raises = evaluate(found.graph, found.outputs, t, points[None], values, [found.raising])
    for j, x in enumerate(points):
        if np.isinf(x) and raises[0, j]:
            continue
        try:
            theirs = of_state(0.0, [x])
        except ValueError:
            assert raises[0, j], (name, x)
            continue
        assert not raises[0, j], (name, x)
        largest = np.max(np.abs(theirs[np.isfinite(theirs)]), initial=1.0)
        np.testing.assert_allclose(mine[:, j], theirs, 1e-8, 1e-8 * largest, err_msg=f"{name} {x}")


def places(rng, x):
    beside = np.nextafter(x, 9), np.nextafter(x, -9), (x[1:] + x[:-1]) / 2
    apart = rng.uniform(x[0] - 0.5, x[-1] + 0.5, 20)
    return np.concatenate([x, *beside, apart, [x[0] - 3, x[-1] + 3, np.nan, np.inf, -np.inf]])


@pytest.mark.few
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("end", ENDS)
def test_interp1d(kind, end, seed):
    rng = np.random.default_rng(seed)
    x, y = drawn(rng)
    for error in (None, False, True):
        if error and end not in ("nan", "number"):
            continue
        rows = rng.normal(size=(2, N)) if end == "columns" else y
        more = {"kind": kind, "fill_value": ENDS[end]}
        spline = interpolate.interp1d(x, rows, bounds_error=error, **more)
        agrees(lambda v, spline=spline: spline(v), places(rng, x), error)
        agrees(lambda v, spline=spline: spline(np.array([v, 0.3])), places(rng, x), error)


def splines(x, y, rng):
    wide = np.stack([y, y[::-1]], 1)
    closed = np.append(y[:-1], y[0])
    yield interpolate.CubicSpline(x, closed, bc_type="periodic")
    yield interpolate.Akima1DInterpolator(x, y)
    how: Any
    for extrapolate in (None, True, False, "periodic"):
        for heights in (y, wide):
            yield interpolate.CubicSpline(x, heights, extrapolate=extrapolate)
            yield interpolate.PchipInterpolator(x, heights, extrapolate=extrapolate)
        for k in (0, 1, 3):
            knots = np.sort(rng.normal(size=N + k + 1))
            how = True if extrapolate is None else extrapolate
            yield interpolate.BSpline(knots, wide, k, extrapolate=how)
            one = interpolate.make_interp_spline(x, y, k=k)
            one.extrapolate = how
            yield one
    for k in (1, 2, 3, 5):
        for ext in range(4):
            yield interpolate.UnivariateSpline(x, y, k=k, s=0.3, ext=ext)
            yield interpolate.InterpolatedUnivariateSpline(x, y, k=k, ext=ext)


@pytest.mark.filterwarnings("ignore:invalid value encountered in remainder")
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(3))
def test_splines(seed):
    rng = np.random.default_rng(seed)
    x, y = drawn(rng)
    refused = 0
    for i, spline in enumerate(splines(x, y, rng)):
        ways = [lambda v, f=spline: f(v), lambda v, f=spline: f(v, 1)]
        if getattr(spline, "k", 1) > 0 or SCIPY >= (1, 17):  # earlier ones end the process
            ways += [lambda v, f=spline: f(v, 2)]
        ways += [lambda v, f=spline: f.derivative()(v), lambda v, f=spline: f.antiderivative()(v)]
        ways += [lambda v, f=spline: f([v, 0.1])]
        for way in ways:
            try:
                way(0.0)
            except ValueError as error:
                if "order" in str(error).lower() or "der" in str(error):
                    continue
            try:
                agrees(way, places(rng, x), (i, spline))
            except Untraceable:
                refused += 1
    assert refused < 50  # of 440: orders above the degree, the ends of a derivative


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(40))
def test_interp(seed):
    rng = np.random.default_rng(seed)
    x, y = np.sort(rng.normal(size=rng.integers(1, 8)).round(1)), rng.normal(size=8)
    y = y[: len(x)]
    if seed % 5 == 0:
        y[rng.integers(len(y))] = (np.inf, np.nan)[seed % 2]
    if seed % 3 == 0:
        x[-1] = np.inf
    points = places(rng, np.sort(rng.normal(size=5)))
    points = np.concatenate([points, x])
    more = [{}, {"left": -7.0}, {"right": 8.0}, {"left": np.nan, "right": np.inf}]
    if np.isfinite(x).all():
        more += [{"period": 1.7}, {"period": -0.9, "left": 4.0}]
    with np.errstate(all="ignore"):
        for given in more:
            agrees(lambda v, given=given: np.interp(v, x, y, **given), points, given)
            items = x.tolist(), y.tolist()
            agrees(lambda v, given=given, i=items: np.interp([v, 1.0], *i, **given), points, given)
    side: Any
    for side in ("left", "right"):
        agrees(lambda v, side=side: np.searchsorted(x, v, side), points)
    for right in (False, True):
        agrees(lambda v, right=right: np.digitize(v, x, right), points)
        agrees(lambda v, right=right: np.digitize(v, x[::-1], right), points)


@pytest.mark.few
@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_entry_of_a_table(seed):
    """Equal entries, equal distances, entries in any order; a search, where they rise."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.normal(size=40).round(seed))
    points = np.concatenate([places(rng, x), rng.normal(size=20).round(seed + 1)])
    with np.errstate(all="ignore"):
        agrees(lambda v: np.argmin(np.abs(x - v)), points)
        agrees(lambda v: abs(v - x).argmin(), points)
        agrees(lambda v: np.argmin(np.abs(x[::-1] - v)), points)
        agrees(lambda v: np.argmin((x - v) ** 2), points)

    found = trace(lambda t, y: [np.argmin(np.abs(x - y[0]))], (), 1, (1,))
    assert sum(node.op == "search" for node in live(found.outputs)) == 2
    far = np.array([0.5, 1e17])  # from where all entries are as near, by rounding
    raising = evaluate(found.graph, [], 0 * far, far[None], found.graph.values, [found.raising])[1]
    assert raising.tolist() == [[False, True]]


def test_in_between_of_complex_numbers():
    x, y = drawn(np.random.default_rng(1))
    z = y + 1j * y[::-1]
    agrees(lambda v: np.abs(np.interp(v, x, z)), np.linspace(-2.0, 2.0, 31))


def solved_alike(fun):
    with warnings.catch_warnings():
        warnings.simplefilter("error", fastdyn.CompileWarning)
        mine = fastdyn.solve_ivp(fun, (0.0, 1.0), [0.5], max_step=1 / 64, atol=1e3)
    theirs = reference(fun, (0.0, 1.0), [0.5], max_step=1 / 64, atol=1e3)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)


X, Y = np.linspace(-0.2, 1.2, N), np.sin(7 * np.arange(N))


def interp1d(**more):
    return interpolate.interp1d(X, Y, **more)


CHANGES = {
    "y": (interp1d, lambda f: setattr(f, "y", 2 * Y)),
    "y in place": (interp1d, lambda f: f.y.__setitem__(3, 9.0)),
    "x": (interp1d, lambda f: setattr(f, "x", X + 0.05)),
    "previous": (lambda: interp1d(kind="previous"), lambda f: f._y.__imul__(2)),
    "fill value": (
        lambda: interp1d(bounds_error=False, fill_value=1.0),
        lambda f: (setattr(f, "x", X / 2), setattr(f, "fill_value", (4.0, 5.0))),
    ),
    "beyond": (
        lambda: interp1d(kind="nearest"),
        lambda f: (setattr(f, "bounds_error", False), setattr(f, "fill_value", "extrapolate")),
    ),
    "spline": (lambda: interpolate.CubicSpline(X, Y), lambda f: f.c.__imul__(2)),
    "of FITPACK": (
        lambda: interpolate.UnivariateSpline(X, Y, s=0.0),
        lambda f: f.set_smoothing_factor(1.0),
    ),
    "b-spline": (lambda: interpolate.make_interp_spline(X, Y), lambda f: setattr(f, "c", -f.c)),
}


@pytest.mark.parametrize("name", CHANGES)
def test_never_stale(name):
    make, change = CHANGES[name]
    spline = make()

    def fun(t, y):
        return spline(t) - y

    solved_alike(fun)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        change(spline)
    solved_alike(fun)


@pytest.mark.parametrize("n", [N, 100_000])
def test_made_inside(n):
    x = np.linspace(-1.0, 2.0, n)
    tck = interpolate.splrep(x[::500] if n > N else x, np.sin(x[::500] if n > N else x))

    def fun(t, y):
        beyond: Any = "extrapolate"
        made = interpolate.PchipInterpolator([0.0, 0.4, 1.0], [1.0, 3.0, 2.0])
        line = interpolate.interp1d([0.0, 2.0], [1.0, y0], fill_value=beyond)
        return made(t) * line(t) - y + interpolate.splev(t, tck) + long(t)

    y0, long = 3.0, interpolate.CubicSpline(x, np.sin(x))
    solved_alike(fun)
    y0 = 5.0
    solved_alike(fun)
