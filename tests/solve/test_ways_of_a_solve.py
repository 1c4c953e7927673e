"""Each way to solve again gives the bits of a first solve: a table of problems, a table of ways.

A new output or option is a problem more, a new kind of solver a way more.
"""

import copy
import itertools
import pathlib
import pickle
import tempfile
from typing import Any, NamedTuple

import numpy as np
import pytest

from fastdyn import Stepper, prepare, solve_ensemble, solve_ivp
from fastdyn.run import checkpoint, loop
from support.masses import decaying
from support.repeated import assert_first, the_long_way

SPAN, TIGHT = (0.0, 1.0), {"rtol": 1e-6, "atol": 1e-9}
TIMES = np.linspace(*SPAN, 5)


PAIRS = ("Tsit5", "DOP853", "RK45", "Rodas5P")
IMPLICIT = ("Rodas5P", "Radau", "BDF", "LSODA")
KEPT = ("RK45", "Vern7", *IMPLICIT)
OF_FORM = ("VelocityVerlet", "BlanesMoanPRK4", "GaussNystrom8")  # for q'' = a(t, q)


class Case(NamedTuple):
    """A problem, and what calls after the first give in place of its own values."""

    fun: Any
    given: dict
    calls: list
    methods: tuple = PAIRS
    ways: tuple = ()  # of WAYS; without any, all of them


def driven(t, y, u, k):
    return [y[1], -k * y[0] + u * np.cos(t)]


def rises(t, y, u, k):
    return y[0]


def falls_to(t, y, u, k):
    return y[0] + 100.0


def halved(t, y, u, k):
    return [y[0], 0.5 * y[1]]


def kicks(t, y, u, k):
    return [y[0] + 0.1, y[1]]


def above(t, y, u, k):
    return y[0] + 0.9 - 0.1 * u


def slope(t, y, u, k):
    return [[0.0, 1.0], [-k, 0.0]]


def steady(t, y, u, k):
    return [y[1], -2.0 * y[0] + u * np.cos(t) + k]


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


def falls(t, y, k):
    return y[0] - 0.8


def lifted(t, y, k):
    return [4.0 * y[0], 0.0]


def ends(t, y, u, k):
    return y[0] - 0.8


ends.terminal = True


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
    "sensitivity": of_driven(sensitivity=("u", "y0"))._replace(methods=(*PAIRS, "Taylor")),
    "sensitivity and events": of_driven(sensitivity="k", events=[rises, falls_to])._replace(
        methods=(*PAIRS, "Taylor")
    ),
    "sensitivity and dense": of_driven(sensitivity="u", dense_output=True, t_eval=TIMES),
    "adjoint": of_driven(adjoint=("y0", "u"), t_eval=TIMES),
    "adjoint of all steps": of_driven(adjoint="u"),
    "breakpoints": of_driven(breakpoints=[0.4, 1.4]),
    "every": of_driven(every=0.3, on_event=kicks),
    "events that act": of_driven(events=rises, on_event=kicks),
    "actions of several": of_driven(
        events=[rises, falls_to], every=[0.3, 0.5], on_event=[kicks, None, halved, kicks]
    ),
    "projection": of_driven(project=halved, events=rises, on_event=kicks)._replace(
        methods=("RK45", "Vern7")
    ),
    "an event that ends the run": of_driven(
        events=[ends, rises], every=0.3, on_event=[None, None, kicks]
    ),
    "longest step": of_driven(max_step=0.07),
    "constant steps": Case(driven, DRIVEN | {"step": 0.1}, CALLS, ("RK4",)),
    "second order": Case(driven, DRIVEN | {"step": 0.1, "dense_output": True}, CALLS, OF_FORM),
    "second order and events": Case(
        driven, DRIVEN | {"step": 0.07, "events": rises, "on_event": kicks}, CALLS, OF_FORM
    ),
    "second order and times": Case(
        driven, DRIVEN | {"step": 0.07, "t_eval": TIMES}, CALLS, OF_FORM
    ),
    "nonnegative": of_driven(nonnegative=[0], dense_output=True)._replace(methods=KEPT),
    "domain": of_driven(domain=above, events=rises)._replace(methods=KEPT),
    "kept inside": of_driven(
        nonnegative=[0], domain=above, events=falls_to, every=0.3, on_event=[kicks, halved]
    )._replace(methods=KEPT),
    "jac": of_driven(jac=slope, t_eval=TIMES)._replace(methods=IMPLICIT),
    "jac kept inside": of_driven(jac=slope, nonnegative=[0], domain=above)._replace(
        methods=IMPLICIT
    ),
    "jac that is a matrix": Case(
        steady, DRIVEN | TIGHT | {"jac": [[0, 1], [-2, 0]], "events": rises}, CALLS, IMPLICIT
    ),
    "error estimate": of_driven(error_estimate=True, events=rises)._replace(
        methods=(*PAIRS, "Taylor", "auto"), ways=("again",)
    ),
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


def stepped(case, method):
    """A Stepper, after each second step its copy: the states after steps, and what events found."""
    for call in ({}, *case.calls):
        given = of(case, method, call)
        t0, tf = given.pop("t_span")
        given.pop("dense_output", None)
        stepper = Stepper(case.fun, t0, given.pop("y0"), tf, **given)
        states = [(stepper.t, stepper.y.copy())]
        while stepper.status == "running":
            assert stepper.step() is None
            if len(states) % 2:
                stepper = copy.deepcopy(stepper)
            states.append((stepper.t, stepper.y.copy()))
        t, y = map(np.array, zip(*states, strict=True))
        names = "t_events", "y_events", "n_accepted", "n_rejected"
        yield {"t": t, "y": y.T, **{name: getattr(stepper, name) for name in names}}, call


def member(case, method):
    """One trajectory of an ensemble without lanes, whose output without times is its end."""
    for call in ({}, *case.calls):
        given = of(case, method, call)
        fun, span, y0 = case.fun, given.pop("t_span"), given.pop("y0")
        found = solve_ensemble(fun, span, [y0, y0], simd=False, **given)[1]
        if found.y_events is not None:  # SciPy's empty lists of states have no axis of components
            found["y_events"] = [y if len(y) else np.empty(0) for y in found.y_events]
        yield {name: value for name, value in found.items() if value is not None}, call


def resumed(case, method):
    """A solve that is interrupted in its second chunk of two steps, and goes on from its file."""
    n_interrupted = 0
    for call in ({}, *case.calls):
        looks = []

        def due(self, looks=looks):
            looks.append(self)
            if len(looks) == 2:
                raise KeyboardInterrupt
            return False

        with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
            given = {"checkpoint": pathlib.Path(folder) / "run.npz", **of(case, method, call)}
            patch.setattr(loop.Run, "n_first", lambda self: 2)
            patch.setattr(loop, "next_chunk", lambda n_steps, spent: 2)
            patch.setattr(checkpoint.Checkpoint, "due", due)
            try:
                found = solve_ivp(case.fun, **given)  # in fewer chunks
            except KeyboardInterrupt:
                n_interrupted += 1
                found = solve_ivp(case.fun, **given)
        yield found, call
    assert n_interrupted


def of_steps(first):
    """A result with the later of two states at one time, which a Stepper has."""
    last = np.r_[np.diff(first.t) != 0.0, True]
    return first | {"t": first.t[last], "y": first.y[:, last]}


def of_end(first):
    """A result whose output is its end."""
    return first | {"t": first.t[-1:], "y": first.y[:, -1:]}


WAYS = {
    "again": again,
    "prepared": lambda case, method: called(prepared(case, method), case),
    "moved": lambda case, method: moved(prepared(case, method), case),
    "copied": copied,
}
STEPPED = {
    "steps", "dense", "events", "breakpoints", "every", "events that act",
    "an event that ends the run", "longest step", "constant steps", "mass", "mass and actions",
    "second order",
}  # fmt: skip
OTHER_WAYS = {  # the way, the cases that it takes, and what it has of the first result
    # a hair before a breakpoint, a Stepper has the state, and solve_ivp that at the breakpoint
    "stepped": (stepped, STEPPED - {"breakpoints"}, of_steps),
    "member": (member, STEPPED - {"dense", "second order"} | {"times"}, of_end),
    "resumed": (resumed, STEPPED | {"times"}, None),
}
PRODUCT = [
    pytest.param(CASES[name], method, WAYS[way], None, id=f"{name}-{way}-{method}")
    for name in CASES
    for way in CASES[name].ways or WAYS
    for method in CASES[name].methods
]
PRODUCT += [
    pytest.param(
        CASES[name], method, way, None if name == "times" else part, id=f"{name}-{word}-{method}"
    )
    for word, (way, names, part) in OTHER_WAYS.items()
    for name in CASES
    if name in names
    for method in CASES[name].methods
]


@pytest.mark.few(64)
@pytest.mark.parametrize(("case", "method", "way", "part"), PRODUCT)
def test_the_bits_are_those_of_a_first_solve(case, method, way, part):
    known = {}
    for found, call in way(case, method):
        if repr(call) not in known:
            known[repr(call)] = first(case, method, call)
        expected = known[repr(call)]
        if part is not None:
            expected = part(expected)
        if found.__class__ is dict:
            expected = {name: expected[name] for name in found}
        assert_first(found, expected)


def test_derivatives_by_discrete_states_have_an_axis_of_their_own():
    found = first(CASES["sensitivity to discrete states"], "RK45", {})
    assert found.sensitivity["discrete"].shape == (2, 1, len(found.t))
