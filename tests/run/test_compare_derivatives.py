"""The code of derivatives is compared with differences of the function along the solution."""

import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile.derivatives import jacobian as jacobians
from fastdyn.compile.derivatives import sensitivities
from fastdyn.trace.graph import derivatives
from fastdyn.trace.graph.expressions import Graph


def stiff(t, y, k=40.0):
    return [-k * (y[0] - np.cos(t)) + y[1] ** 2, y[0] * y[1] - y[1] ** 3]


def kinked(t, y):
    return [-3.0 * abs(y[0]) + max(y[1], 0.2), np.where(y[1] > 0.5, -y[1], -0.5 * y[1]) - y[0]]


def long(t, y):
    d = np.zeros_like(y)
    d[1:-1] = 50.0 * (y[2:] - 2.0 * y[1:-1] + y[:-2]) - y[1:-1] ** 3 - np.sin(t)
    return d


def on_a_kink(t, y):  # where it stays
    empty, level = max(y[1], 0.0), np.maximum(y[2] - 0.5, 0.0)
    return [-abs(y[0]) - empty, -empty - abs(y[1]) + 0.0 * t, -3.0 * level * y[0]]


def tiny(t, y):
    return [-3e-18 * y[0] / (1e-18 + y[0]), 1e18 * y[0] ** 2 - y[1]]


def wound(t, y):
    return [1.0 + 0.5 * np.sin(y[0]), np.cos(y[0]) - 30.0 * y[1]]


def in_a_layer(t, y):
    return [1.0 - 2.0 * np.tanh(1e7 * (y[0] - 1.0)), -20.0 * (y[1] - y[0])]


def forced(t, y):
    return [-50.0 * (y[0] - np.sin(300.0 * t)), y[0] - y[1] ** 3]


def at_its_bound(t, y):
    return [-np.sqrt(np.maximum(1.0 - y[0], 0.0)) + 1e-3 * y[1], -0.2 * np.sqrt(abs(y[1]))]


def of_a_table(t, y):
    k = np.interp(y[0], [0.0, 0.3, 0.5, 0.7, 2.0], [0.0, 1.0, 4.0, 4.5, 9.0])
    return [-k + 0.2 * y[1], np.floor(3 * y[0]) - 10.0 * y[1]]


def cancelling(t, y):
    return [(y[0] + 1e9) - 1e9 - 2.0 * y[0], -1e6 * (y[0] * y[1] - 0.25)]


def still(t, y):
    return [-y[0] * y[1], 0.0 * y[1], y[1] * y[0] * 1e-3]


STARTS = {
    stiff: [1.0, 0.7], kinked: [1.0, 0.9], long: np.linspace(0, 1, 300) ** 2,
    on_a_kink: [0.0, 0.0, 0.5], tiny: [4e-18, 0.0], wound: [1e6, 0.0], in_a_layer: [1.0, 1.0],
    forced: [0.0, 1.0], at_its_bound: [1.0, 0.0], of_a_table: [0.5, 0.1], cancelling: [0.5, 0.5],
    still: [0.0, 0.0, 0.0],
}  # fmt: skip
TOLERANCES = {
    tiny: {"rtol": 1e-6, "atol": 1e-24},
    in_a_layer: {"rtol": 1e-3},  # at 1e-6, LSODA takes millions of steps, 8 s
}
METHODS = ["Radau", "BDF", "LSODA", "Rodas5P"]


@pytest.fixture
def wrong_products(monkeypatch):
    """Derivatives in which an element, and that with respect to a parameter, is not right."""
    of_state, partials = derivatives.jacobian, derivatives.partials

    def wrong(node, g):
        return g.mul(g.const(1.5), node)

    def jacobian(g, *given):
        rows, columns, nodes = of_state(g, *given)
        return rows, columns, [*(wrong(v, g) for v in nodes[:1]), *nodes[1:]]

    def of_inputs(g, *given):
        first, *rest = partials(g, *given)
        return [first | {i: wrong(first[i], g) for i in {min(first), max(first)}}, *rest]

    monkeypatch.setattr(jacobians, "derivatives", jacobian)
    monkeypatch.setattr(sensitivities, "partials", of_inputs)


@pytest.mark.few(5)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("fun", STARTS)
def test_right_derivatives_are_no_difference(fun, method):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tolerances = TOLERANCES.get(fun, {"rtol": 1e-6})
        r = fastdyn.solve_ivp(fun, (0, 3), STARTS[fun], method=method, **tolerances)
    assert r.success


@pytest.mark.parametrize("method", METHODS)
def test_a_wrong_jacobian_is_not_used(method, wrong_products):
    k = 40 + METHODS.index(method)  # each has code of its own
    fun = eval(f"lambda t, y: [-{k} * (y[0] - np.cos(t)) + y[1] ** 2, y[0] * y[1] - y[1] ** 3]")
    given, how = (fun, (0, 3), [1.0, 0.7]), {"rtol": 1e-6, "atol": 1e-8}
    theirs = scipy.integrate.solve_ivp(*given, method="Radau", **how)
    with pytest.warns(fastdyn.CompileWarning, match="its compiled derivative along a vector"):
        ours = fastdyn.solve_ivp(*given, method=method, **how)
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-4)


@pytest.mark.parametrize("sensitivity", ["y0", "k", ("y0", "k")])
def test_wrong_sensitivities_are_refused(sensitivity, wrong_products):
    def fun(t, y, k):
        return [-k * (y[0] - np.cos(t)) + y[1] ** 2, y[0] * y[1] - y[1] ** 3]

    with pytest.raises(ValueError, match="its compiled derivative along a vector"):
        fastdyn.solve_ivp(fun, (0, 3), [1.0, 0.7], args=(4.5,), sensitivity=sensitivity)


RATES = {
    "plain": lambda t, y, k, b: [
        -k * (y[0] - b[0] * np.cos(t)) + y[1] ** 2, y[0] * y[1] - b[1] * y[1] ** 3
    ],
    "tiny": lambda t, y, k, b: [
        -1e-12 * b[0] * y[0] / (1e-12 * k + y[0]), -b[1] * y[1] * y[0] * 1e12 * k
    ],
    "still": lambda t, y, k, b: [b[0] * y[0] * y[1], k * b[1] * y[1]],
    "wound": lambda t, y, k, b: [1.0 + 0.5 * np.sin(1e6 + y[0]), np.cos(k * y[0]) - b[0] * y[1]],
    "steep": lambda t, y, k, b: [-np.exp(k * y[1]) * y[0], b[0] - y[1] ** 2 * b[1]],
    "cancelling": lambda t, y, k, b: [(y[0] * b[0] + 1e6) - 1e6 - k * y[0], y[0] - y[1]],
}  # fmt: skip


@pytest.mark.parametrize("sensitivity", ["y0", "k", ("y0", "k"), "b", ("y0", "args")])
@pytest.mark.parametrize("rates", RATES)
def test_right_sensitivities_stand(rates, sensitivity):
    start = {"tiny": [1e-12, 1.0], "still": [0.0, 0.0]}.get(rates, [1.0, 0.7])
    args, of = (4.0, np.array([1.0, 0.8])), {"args": ("k", "b")}
    for span in ((0, 1), (0, 6)):
        r = fastdyn.solve_ivp(
            RATES[rates], span, start, args=args, sensitivity=of.get(sensitivity, sensitivity),
            rtol=1e-6, atol=1e-9 * (start[0] or 1.0), method="DOP853",
        )  # fmt: skip
        assert r.success


def test_rates_of_a_state_with_sensitivities_are_compared(monkeypatch):
    select = Graph.select
    wrong = lambda g, chosen, a, b: select(g, chosen, a, g.mul(g.const(3.0), b))  # noqa: E731
    monkeypatch.setattr(Graph, "select", wrong)
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)

    def fun(t, y, k):
        return [-k * y[0] if y[0] > 0.2 else -k * y[0] - 0.3 * (0.2 - y[0])]

    with pytest.raises(ValueError, match=r"its compiled form gives .* and Python"):
        fastdyn.solve_ivp(fun, (0, 3), [1.0], args=(1.0,), sensitivity="k")
