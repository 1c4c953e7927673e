"""What has no adjoint, and wrong arguments of `vjp`, are told in sentences."""

import time

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.trace.graph.reverse import pullback


def pendulum(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


@pytest.mark.parametrize(
    ("g", "error", "words"),
    [
        (np.ones((2, 3)), ValueError, r"so its shape, \(2, 5\); got \(2, 3\)"),
        (np.ones((5, 2)), ValueError, "shape"),
        (1.0, ValueError, "shape"),
        (np.full((2, 5), np.nan), ValueError, "nan or inf"),
        (np.ones((2, 5)) * 1j, TypeError, "real numbers"),
        ([["a"] * 5] * 2, TypeError, "real numbers"),
        (None, TypeError, "real numbers"),
    ],
)
def test_what_is_no_derivative_by_the_outputs(g, error, words):
    given = (pendulum, (0, 1), [1.0, 0.3])
    r = solve_ivp(*given, t_eval=np.linspace(0, 1, 5), args=(9.81, 0.2), adjoint="args")
    with pytest.raises(error, match=words):
        r.vjp(g)
    assert r.vjp(np.ones((2, 5), int).tolist())["damping"] > 0


def friction(t, y, mu):
    return [y[1], -y[0] - mu * np.sign(y[1])]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "BDF"}, "RK45, .*RK4, .* and not over those of BDF"),
        ({"method": "Taylor"}, "not over those of Taylor"),
        ({"y0": [1j, 0]}, "real states"),
        ({"y0": []}, "a state, and a span"),
        ({"t_span": (1, 1)}, "a span that is finite and not empty"),
        ({"t_eval": []}, "`t_eval` is empty"),
        ({"dense_output": True}, "`dense_output` do not go together: .*`t_eval`"),
        ({"vectorized": True}, "`vectorized` do not go together"),
        ({"events": lambda t, y: [time.time(), y[0]][1]}, "takes events.* in compiled code"),
        (
            {"events": fastdyn.at([1.0]), "on_event": lambda t, y: [time.time(), y[0]]},
            "takes events.* in compiled code",
        ),
        ({"sensitivity": "y0"}, "`sensitivity` do not go together"),
        ({"error_estimate": True}, "`error_estimate` do not go together"),
        ({"callback": print}, "`callback` do not go together"),
        ({"project": lambda t, y: y}, "`project` do not go together"),
        ({"nonnegative": True}, "`nonnegative` do not go together"),
        ({"checkpoint": "there"}, "`checkpoint` do not go together"),
        ({"fun": lambda t, y: [time.time(), 1.0]}, "it uses time"),
        ({"fun": lambda t, y: [__import__("math").gamma(y[0]), 1.0]}, "tgamma"),
        ({"fun": friction, "args": (0.1,), "t_span": (0, 10)}, r"jumps at t = 0\.\d+.*derivatives"),
        ({"adjoint": "zz"}, "`adjoint='zz'` is unknown"),
        ({"adjoint": []}, "`adjoint` names nothing"),
        ({"y0": np.ones(70_000), "fun": lambda t, y: -y}, "at most 60000 operations"),
        ({"max_steps": 3}, "of a solve that failed: `max_steps"),
    ],
)
def test_what_has_no_adjoint_is_told(options, words):
    given = {
        "fun": lambda t, y: [y[1], -y[0]], "t_span": (0, 5), "y0": [1.0, 0.3], "adjoint": "y0",
    }  # fmt: skip
    with pytest.raises(ValueError, match=words):
        r = solve_ivp(**given | options)
        r.vjp(np.ones_like(r.y))


def test_a_wrong_product_is_found_by_differences(monkeypatch):
    def wrong(graph, outputs, cotangents, inputs, entries):
        *found, last = pullback(graph, outputs, cotangents, inputs, entries)
        return [*found, graph.mul(graph.const(1.5), last)]

    monkeypatch.setattr("fastdyn.compile.derivatives.vjp.pullback", wrong)
    fun = lambda t, y, a, b: [-a * y[0] * y[1] + 0.3, -b * y[1] * np.cos(y[0])]  # noqa: E731
    with pytest.raises(ValueError, match=r"along a vector is .*, and differences give"):
        solve_ivp(fun, (0, 3), [1.0, 2.0], args=(1.5, 0.7), adjoint=("y0", "args"))


def test_infinite_derivatives_are_told():
    r = solve_ivp(lambda t, y: [1.0 + 0 * y[0], np.sqrt(y[0])], (0, 1), [0.0, 0.0], adjoint="y0")
    with pytest.raises(ValueError, match="nan or inf: `fun` has an infinite derivative"):
        r.vjp(np.ones_like(r.y))
