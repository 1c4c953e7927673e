"""A refusal that ends a call is not remembered: the next call looks at what is mended."""

import pytest

import fastdyn
from fastdyn.compile.traced import make

SPAN, ARGS = (0.0, 1.0), (2.0,)


class Word(str):
    """A word of a class that no trace reads."""


def decaying(mode):
    return lambda t, y, k: [-k * y[0] * (1.0 if mode["is"] == "fast" else 0.5)]


def delayed(mode):
    return lambda t, y, past, k: [-k * past(t - 0.5)[0] * (1.0 if mode["is"] == "fast" else 0.5)]


def residual(mode):
    def F(t, y, yp, k):
        return [yp[0] + k * y[0] * (1.0 if mode["is"] == "fast" else 0.5), y[1] - y[0]]

    return F


def reduced(mode):
    def F(t, y, yp, k):
        return [yp[0] - y[1], y[0] - k * t * (1.0 if mode["is"] == "fast" else 0.5)]

    return F


CALLS = {
    "adjoint": lambda mode: fastdyn.solve_ivp(
        decaying(mode), SPAN, [1.0], args=ARGS, adjoint="args"
    ),
    "sensitivity": lambda mode: fastdyn.solve_ivp(
        decaying(mode), SPAN, [1.0], args=ARGS, sensitivity="args"
    ),
    "an ensemble": lambda mode: fastdyn.solve_ensemble(
        decaying(mode), SPAN, [[1.0]], args=ARGS, sensitivity="args"
    ),
    "Taylor": lambda mode: fastdyn.solve_ivp(decaying(mode), SPAN, [1.0], "Taylor", args=ARGS),
    "delays": lambda mode: fastdyn.solve_dde(delayed(mode), SPAN, [1.0], args=ARGS),
    "derivatives by a past": lambda mode: fastdyn.solve_dde(
        delayed(mode), SPAN, [1.0], args=ARGS, delays=[0.5], sensitivity="k"
    ),
    "residuals": lambda mode: fastdyn.solve_dae(
        residual(mode), SPAN, [1.0, 1.0], args=ARGS, sensitivity="args"
    ),
    "an index of 2": lambda mode: fastdyn.solve_dae(reduced(mode), SPAN, [0.0, 2.0], args=ARGS),
}


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_call_that_is_mended_is_solved(name):
    mode = {"is": Word("fast")}
    for _ in range(make.MAX_REFUSALS + 1):
        with pytest.raises(ValueError, match="Word"):
            CALLS[name](mode)
    mode["is"] = "slow"
    CALLS[name](mode)
