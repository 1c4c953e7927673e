"""Each way to solve again gives the bits of a first solve: a table of problems, a table of ways.

A new output or option is a problem more, a new kind of solver a way more.
"""

import itertools
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from support.repeated import assert_first, the_long_way

SPAN, TIGHT = (0.0, 1.0), {"rtol": 1e-6, "atol": 1e-9}
TIMES = np.linspace(*SPAN, 5)


class Case(NamedTuple):
    """A problem, and what calls after the first give in place of its own values."""

    fun: Any
    given: dict
    calls: list
    methods: tuple = ("Tsit5", "DOP853", "RK45", "Rodas5P")


def driven(t, y, u, k):
    return [y[1], -k * y[0] + u * np.cos(t)]


def rises(t, y, u, k):
    return y[0]


def kicks(t, y, u, k):
    return [y[0] + 0.1, y[1]]


def swing(t, y, k, weights):
    return [y[1], -k * np.sin(y[0]) - weights[0] * y[1] + weights[1]]


def filled(t, y, d, rate):
    return [d[0] - rate * y[0]]


def switched(t, y, d, rate):
    return y, [0.5 * d[0], d[1] + 1.0]


def pushed(t, y, d, k):
    return [y[1], -k * y[0] + d[0]]


def turned(t, y, d, k):
    return y, [-k * d[0]]


def decaying(t, y, k):
    x, z = y
    return [-k * x, z + z**3 - x]


def falls(t, y, k):
    return y[0] - 0.8


def lifted(t, y, k):
    return [4.0 * y[0], 0.0]


def on_the_curve(x):
    """A start [x, z] with z + z^3 = x."""
    found = np.roots([1.0, 0.0, 1.0, -x])
    return [x, float(found[np.abs(found.imag).argmin()].real)]


DRIVEN = {"y0": [1.0, 0.0], "args": (0.5, 2.0)}
CALLS = [{"y0": [1.0 + i, 0.1], "args": (0.3 * i, 2.0)} for i in range(3)]
CALLS += [{"y0": [2, 0]}, {"args": (0.7, 1)}]


MASS = {
    "y0": on_the_curve(1.0), "args": (1.0,), "mass": np.diag([1.0, 0.0]), "rtol": 1e-8,
    "atol": 1e-10,
}  # fmt: skip
STARTS = [{"y0": on_the_curve(x), "args": (k,)} for x in (0.5, 2.0, 1e-6) for k in (1.0, 2.5)]
WITH_MASS = ("Rodas5P", "Radau", "BDF")


def of_driven(**options):
    return Case(driven, DRIVEN | TIGHT | options, CALLS)


CASES = {
    "steps": of_driven(),
    "times": of_driven(t_eval=TIMES),
    "dense": of_driven(dense_output=True),
    "events": of_driven(events=rises),
    "all outputs": of_driven(events=[rises, rises], t_eval=[0.5], dense_output=True),
    "sensitivity": of_driven(sensitivity=("u", "y0")),
    "sensitivity and events": of_driven(sensitivity="k", events=rises),
    "adjoint": of_driven(adjoint=("y0", "u"), t_eval=TIMES),
    "adjoint of all steps": of_driven(adjoint="u"),
    "breakpoints": of_driven(breakpoints=[0.4, 1.4]),
    "every": of_driven(every=0.3, on_event=kicks),
    "longest step": of_driven(max_step=0.07),
    "constant steps": Case(driven, DRIVEN | {"step": 0.1}, CALLS, ("RK4",)),
    "mass": Case(decaying, MASS, STARTS, WITH_MASS),
    "mass and actions": Case(
        decaying, MASS | {"events": falls, "on_event": lifted}, STARTS[:3], WITH_MASS
    ),
    "sensitivity to an array": Case(  # values above 1 change the tolerances of columns
        swing,
        {
            "y0": [1.0, 0.0], "args": (2.0, np.array([0.1, 0.3])), "t_eval": TIMES,
            "sensitivity": ("y0", "weights"), **TIGHT,
        },
        [
            {"y0": [0.5, -0.2], "args": (7.5, np.array([0.2, -3.0]))},
            {"y0": [40.0, 0.0], "args": (0.3, np.array([0.2, 0.0]))},
            {"y0": [1, 0], "args": (2, np.array([0.1, 0.3]))},
        ],
    ),
    "discrete states": Case(
        filled,
        {
            "y0": [9.0], "args": (0.4,), "discrete": [9.0, 9.0], "every": 0.3,
            "on_event": switched, "dense_output": True, **TIGHT,
        },
        [
            {"y0": [0.2], "args": (0.7,), "discrete": [3.0, 5.0]},
            {"y0": [7.0], "args": (0.4,), "discrete": [-2.0, 1.0]},
            {"y0": [1.0]},
            {"discrete": [1.0, 2.0]},
        ],
        ("RK45", "Taylor", "Radau"),
    ),
    "sensitivity to discrete states": Case(
        pushed,
        {
            "y0": [1.0, 0.0], "args": (2.0,), "discrete": [0.5], "every": 0.4,
            "on_event": turned, "sensitivity": ("y0", "k"), **TIGHT,
        },
        [{"discrete": [-1.0]}, {"y0": [2.0, 1.0], "args": (0.5,)}],
    ),
}  # fmt: skip


def of(case, method, call=None):
    """The arguments of a solve, apart from `fun`."""
    return {"t_span": SPAN, "method": method} | case.given | (call or {})


def first(case, method, call):
    """The solve by the long way."""
    with the_long_way():
        return solve_ivp(case.fun, **of(case, method, call))


def prepared(case, method):
    """The solver in each of the two tiers, which have the same bits."""
    return prepare(
        case.fun, compile="inlined" if method == "RK45" else "shared", **of(case, method)
    )


def again(case, method):
    """`solve_ivp`, until its run is ready, and with other values."""
    for call in (*[{}] * 4, *case.calls, {}, *case.calls):
        yield solve_ivp(case.fun, **of(case, method, call)), call


def called(solver, case):
    """A prepared solver, with other values and with its own."""
    for call in (*case.calls, {}, *case.calls, {}):
        yield solver(**call), call


def moved(solver, case):
    """Spans move on, as in a controller, and come back to the first."""
    for i, call in enumerate((*case.calls, {}, *case.calls)):
        start = (0.0, 0.3 * (i % 5), 1.0)[i % 3]
        call = call | {"t_span": (start, start + 1.0)}
        if "t_eval" in case.given:
            call["t_eval"] = start + np.asarray(case.given["t_eval"])
        yield solver(**call), call
        yield solver(), {}


def copied(case, method):
    """A copy, as another process gets it, beside its original."""
    original = prepared(case, method)
    copy = pickle.loads(pickle.dumps(original))
    return itertools.chain(called(copy, case), moved(copy, case), called(original, case))


WAYS = {
    "again": again,
    "prepared": lambda case, method: called(prepared(case, method), case),
    "moved": lambda case, method: moved(prepared(case, method), case),
    "copied": copied,
}
PRODUCT = [
    pytest.param(CASES[name], method, WAYS[way], id=f"{name}-{way}-{method}")
    for name, way in itertools.product(CASES, WAYS)
    for method in CASES[name].methods
]


@pytest.mark.few(44)
@pytest.mark.parametrize(("case", "method", "way"), PRODUCT)
def test_the_bits_are_those_of_a_first_solve(case, method, way):
    known = {}
    for found, call in way(case, method):
        if repr(call) not in known:
            known[repr(call)] = first(case, method, call)
        assert_first(found, known[repr(call)])


def test_derivatives_by_discrete_states_have_an_axis_of_their_own():
    found = first(CASES["sensitivity to discrete states"], "RK45", {})
    assert found.sensitivity["discrete"].shape == (2, 1, len(found.t))
