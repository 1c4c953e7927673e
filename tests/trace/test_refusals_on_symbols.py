"""A refusal on symbols, wherever it comes, leaves no public function: others go on, or say why."""

import itertools
import math

import numpy as np
import pytest

import fastdyn
from fastdyn.compile import memory
from fastdyn.specialise.series import NoSeries
from fastdyn.trace.graph import expressions as graph
from fastdyn.trace.graph.refusal import Refusal

START = [1.0, 0.0]
PLACES = [*range(40), *range(40, 200, 9)]  # of the operation that is refused
PART = 4  # of the places, one in so many is tried with each call, without --whole-corpus


def spring(t, y, k=2.0, c=0.1):
    push = 1.0 if y[0] > 0.3 else 0.0
    return [y[1], push - k * y[0] - c * y[1] * abs(y[1])]


def pendulum(t, y, k=2.0):
    return [y[1], -k * math.sin(y[0])]


def crossing(t, y, *args):
    return y[0] - 0.2


def energy(t, y):
    return y[0] ** 2 + y[1] ** 2


def stepped():
    stepper = fastdyn.Stepper(pendulum, 0, START, 3)
    stepper.step()
    return stepper.y


def prepared():
    return fastdyn.prepare(pendulum, (0, 3), START, compile="auto")


def ensemble(fun, **options):
    return fastdyn.solve_ensemble(fun, (0, 3), np.ones((9, 2)), **options).y


def drift():
    study = {"method": "RK4", "y0": START, "invariants": {"energy": energy}}
    fastdyn.energy_drift(pendulum, **study, step=0.1, n_steps=1000)


CALLS = {
    "explicit": lambda: fastdyn.solve_ivp(spring, (0, 3), START, events=crossing).y,
    "implicit": lambda: fastdyn.solve_ivp(spring, (0, 3), START, "Radau", events=crossing).y,
    "mass": lambda: fastdyn.solve_ivp(spring, (0, 3), START, "Rodas5P", mass=np.diag([1, 2.0])).y,
    "series": lambda: fastdyn.solve_ivp(pendulum, (0, 3), START, "Taylor", events=crossing).y,
    "auto": lambda: fastdyn.solve_ivp(pendulum, (0, 3), START, "auto", rtol=1e-8).y,
    "sensitivity": lambda: (
        fastdyn.solve_ivp(pendulum, (0, 3), START, args=(2.0,), sensitivity="args").y
    ),
    "complex": lambda: fastdyn.solve_ivp(lambda t, y: 1j * y, (0, 3), [1 + 0j]).y,
    "second order": lambda: (
        fastdyn.solve.solve_second_order(lambda t, q: -q, (0, 3), [1.0], [0.0], step=0.01).y
    ),
    "prepare": lambda: prepared()().y,
    "many": lambda: prepared().many([START, [2.0, 0.0]]).y,
    "Stepper": stepped,
    "ensemble": lambda: ensemble(pendulum, args=(np.full(9, 2.0),)),
    "stiff ensemble": lambda: ensemble(spring, method="Rodas5P"),
    "series of an ensemble": lambda: ensemble(pendulum, method="Taylor"),
    "drift": drift,
}
MAY_REFUSE = {"series", "sensitivity", "series of an ensemble"}


@pytest.mark.few(5)
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", CALLS)
def test_no_refusal_leaves_a_public_function(name, monkeypatch, request):
    whole = request.config.getoption("--whole-corpus")
    places = PLACES if whole else PLACES[list(CALLS).index(name) % PART :: PART]
    memory.forget()
    expected = CALLS[name]()
    make = graph.Graph.make
    for place in places:
        memory.forget()
        count = itertools.count()

        def refusing(self, *args, last=place, count=count):
            if next(count) >= last:
                raise Refusal("that is not made")
            return make(self, *args)

        monkeypatch.setattr(graph.Graph, "make", refusing)
        try:
            found = CALLS[name]()
        except (NoSeries, ValueError) as reason:
            assert name in MAY_REFUSE
            assert "that is not made" in str(reason) or "could not be traced" in str(reason)
        else:
            if name != "drift":
                assert np.allclose(found[..., -1], expected[..., -1], rtol=2e-2, atol=2e-2)
        monkeypatch.undo()
    memory.forget()
