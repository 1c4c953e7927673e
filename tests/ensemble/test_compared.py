"""The code of ensembles is compared where trajectories go, and vectors with single solves."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastdyn
from fastdyn.compile.traced.code import Traced
from fastdyn.ensemble import compared
from fastdyn.run.functions import compared as of_runs

STARTS = np.linspace(0.9, 1.1, 20)[:, None]
METHODS = ["RK45", "Vern7", "Rodas5P"]


@pytest.fixture
def wrong_vectors(monkeypatch):
    """Vectors whose first rate is another than in the code for one trajectory."""
    text = Traced.vector_text

    def wrong(traced, *given, **more):
        g, (first, *others) = traced.trace.graph, traced.trace.outputs
        outputs = [g.mul(g.const(1.001), first), *others]
        other = Traced(traced.trace._replace(outputs=outputs), traced.mode, traced.n)
        return text(other, *given, **more)

    monkeypatch.setattr(Traced, "vector_text", wrong)


@pytest.mark.few(2)
@pytest.mark.parametrize("simd", ["auto", False])
@pytest.mark.parametrize("method", METHODS)
def test_wrong_code_is_found_where_trajectories_go(method, simd, wrong_choices):
    c = 2.0 + METHODS.index(method) + 0.5 * (simd is False)  # each has code of its own
    fun = eval(f"lambda t, y, k: [-k * y[0] if y[0] > 0.2 else -{c} * y[0]]")
    given = fun, (0, 3), STARTS, (np.linspace(1, 2, 20),), method
    with pytest.warns(fastdyn.CompileWarning, match=r"compiled form gives .* and Python"):
        found = fastdyn.solve_ensemble(*given, simd=simd, rtol=1e-8, atol=1e-12)
    assert found.width == 1 and found.success.all()
    k = given[3][0]
    right = 0.2 * np.exp(-c * (3 - np.log(STARTS[:, 0] / 0.2) / k))
    assert np.allclose(found.y_end[:, 0], right, rtol=1e-5)
    again = fastdyn.solve_ensemble(*given, simd=simd, rtol=1e-8, atol=1e-12)
    assert np.array_equal(again.y_end, found.y_end)  # the code is not used again, in vectors, too


@pytest.mark.parametrize("how", [("RK45", False), ("Vern7", "auto"), ("Rodas5P", "auto"), "many"])
def test_code_that_is_wrong_in_a_pulse_only_is_found(how, wrong_products, monkeypatch):
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)
    c = 1.0 + len(how[0]) / 64 + len(how) / 256  # each has code of its own
    fun = eval(f"lambda t, y, at: [-{c} * y[0] + 3 * np.exp(-(((t - at) / 0.1) ** 2))]")
    at, options = np.linspace(1, 2, 20), {"rtol": 1e-8, "atol": 1e-10}
    with pytest.warns(fastdyn.CompileWarning, match=r"compiled form gives .* and Python"):
        if how == "many":
            solver = fastdyn.prepare(fun, (0, 9), [1.0], args=(5.0,), **options)
            found = solver.many(STARTS, (at,)).y[:, 0]
        else:
            method, simd = how
            given = fun, (0, 9), STARTS, (at,), method
            found = fastdyn.solve_ensemble(*given, simd=simd, **options).y_end[:, 0]
    for i in (0, 19):
        right = solve_ivp(fun, (0, 9), STARTS[i], args=(at[i],), rtol=1e-10, atol=1e-13)
        assert abs(found[i] - right.y[0, -1]) < 1e-4 * abs(right.y[0, -1])


@pytest.mark.parametrize("method", ["RK45", "Rodas5P"])
def test_wrong_vectors_are_found(method, wrong_vectors):
    c = 0.3 + METHODS.index(method)
    fun = eval(f"lambda t, y: [-{c} * y[0]]")
    with pytest.warns(fastdyn.CompileWarning, match="compiled form gives"):
        found = fastdyn.solve_ensemble(fun, (0, 3), STARTS, method=method, rtol=1e-8, atol=1e-12)
    assert np.allclose(found.y_end, STARTS * math.exp(-3 * c), rtol=1e-6)


def lorenz(t, y):
    return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]


def stick(t, y):
    return [y[1], math.sin(t) - 2.0 * y[0] - 0.7 * np.sign(y[1])]


def upright(t, y):
    return [y[1], math.sin(y[0])]


def escaping(t, y):
    return [y[0] ** 2, y[1]]


@pytest.mark.few(4)
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5"])
@pytest.mark.parametrize(
    ("fun", "start", "end"),
    [(lorenz, [1, 1, 1], 60.0), (stick, [1, 0], 30.0), (upright, [math.pi, 0], 200.0),
     (escaping, [1, 1], 2.0)],
)  # fmt: skip
def test_what_rounding_changes_is_no_difference(fun, start, end, method, recwarn):
    starts = np.array(start) * np.linspace(0.9, 1.1, 21)[:, None]
    for times in (None, np.linspace(0, end, 9)):
        fastdyn.solve_ensemble(fun, (0, end), starts, method=method, t_eval=times, max_steps=3000)
    assert not [w for w in recwarn if w.category is fastdyn.CompileWarning]


def test_when_ensembles_are_compared(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare_along", lambda bound, t, y: seen.append(len(t)))
    for when, expected in (
        ("auto", [32, 4, 0, 4, 0, 0, 0, 4]), ("always", [32] + [4] * 7), ("never", [0] * 8),
    ):  # fmt: skip
        monkeypatch.setattr(of_runs, "WHEN", when)
        fun = eval(f"lambda t, y: [-{len(when)}.25 * y[0]]")
        found = []
        for _ in range(8):
            seen.clear()
            fastdyn.solve_ensemble(fun, (0, 1), STARTS, t_eval=np.linspace(0, 1, 11))
            found.append(sum(seen))
        assert found == expected


def test_a_store_is_compared_too(tmp_path, monkeypatch):
    pytest.importorskip("zarr")
    seen = []
    monkeypatch.setattr(compared, "compare_along", lambda bound, t, y: seen.append(len(t)))
    fastdyn.solve_ensemble(
        of_store, (0, 1), STARTS, t_eval=np.linspace(0, 1, 11), store=tmp_path / "store"
    )
    assert seen == [1] * 4


def of_store(t, y):
    return [-5.75 * y[0]]


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_rounding_moves_steps_at_kinks_from_a_start_at_zero():
    """A start at zero has no rounding of its own, and 200 kinks change steps by 2e-8."""
    x, road = np.linspace(0, 100, 200), 0.003 * np.random.default_rng(1).normal(size=200).cumsum()

    def wheel(t, y, k, v):
        return [y[1], -k * (y[0] - np.interp(v * t, x, road)) - 0.6 * y[1]]

    args = np.linspace(20, 80, 8), np.linspace(10, 30, 8)
    how = {"rtol": 1e-8, "atol": 1e-10, "reduce": "mean"}
    assert fastdyn.solve_ensemble(wheel, (0, 3), [0, 0], args, method="RK45", **how).reason == ""
