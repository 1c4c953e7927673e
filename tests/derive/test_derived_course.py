"""The systems of the course, derived: the same motion and reactions as those written by hand."""

import functools
import itertools

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.course.derived import REACTIONS
from fastdyn.derive.pages import page

EPS = np.finfo(float).eps

SAME = {ours: (theirs, forces) for theirs, (ours, forces) in REACTIONS.items()}
LAWS = ("newton", "lagrange")
NEEDS_NEWTON = ("rod", "lagrange")  # friction needs the normal force


@functools.cache
def derived(name, law):
    return getattr(page(name), law)().system


def both(name, law, rng):
    """The derived system and the one written by hand, with the same random numbers."""
    ours, written = derived(name, law), getattr(systems, SAME[name][0])
    numbers = {}
    for one in ours.derivation.model.numbers:
        value = one.default * rng.uniform(0.5, 2.0) + (one.default == 0.0) * rng.normal()
        numbers[str(one.symbol)] = value
    known = {field: numbers[field] for field in numbers if hasattr(written, field)}
    return ours(**numbers), written(**known)


def states(system, rng, count=20):
    """Random states, on the constraints where there are any."""
    start = np.array(system.initial_state())
    for _ in range(count):
        y = start + np.maximum(1.0, np.abs(start)) * rng.normal(size=len(start)) * 0.5
        t = rng.uniform(0.0, 3.0)
        if system.constraints:
            for _ in range(5):
                y = np.array(system.project(t, y, *system.args))
        yield t, y


def rounding(function, t, y, args):
    """How much a value of a function changes when its arguments change by their rounding."""
    value, total = np.array(function(t, y, *args), float), 0.0
    numbers = [n for n, one in enumerate(args) if isinstance(one, float)]
    for sign in (-1.0, 1.0):
        for n in range(len(y)):
            near = y.copy()
            near[n] += sign * EPS * max(1.0, abs(y[n]))
            total += np.abs(np.array(function(t, near, *args), float) - value)
        for n in numbers:
            near = list(args)
            near[n] *= 1.0 + sign * EPS
            total += np.abs(np.array(function(t, y, *near), float) - value)
    return total + EPS * np.abs(value)


OPERATIONS = 200  # roundings in a right-hand side, at most, each as large as one of an argument


@pytest.mark.few(6)
@pytest.mark.parametrize(
    ("name", "law"), [each for each in itertools.product(SAME, LAWS) if each != NEEDS_NEWTON]
)
def test_derived_motion_and_reactions_are_those_written_by_hand(name, law):
    rng = np.random.default_rng(7)
    for _ in range(3):
        ours, written = both(name, law, rng)
        assert ours.initial_state() == pytest.approx(written.initial_state(), rel=4 * EPS)
        for t, y in states(ours, rng):
            off = np.array(ours.rhs(t, y, *ours.args)) - written.rhs(t, y, *written.args)
            allowed = OPERATIONS * rounding(ours.rhs, t, y, ours.args)
            scale = np.abs(written.rhs(t, y, *written.args)).max()
            assert np.all(np.abs(off) <= allowed + 64 * EPS * scale), (t, y, off)
            for here, there in SAME[name][1].items():
                if here not in ours.quantities:
                    assert law == "lagrange" and name == "pendulum"
                    continue
                force = ours.quantities[here]
                off = force(t, y, *ours.args) - written.quantities[there](t, y, *written.args)
                assert abs(off) <= OPERATIONS * rounding(force, t, y, ours.args)


@pytest.mark.parametrize("name", SAME)
def test_derived_solution_is_that_of_the_hand(name):
    ours, written = derived(name, "newton")(), getattr(systems, SAME[name][0])()
    t_span = (0.0, min(ours.t_end, 10.0))
    at = np.linspace(*t_span, 50)
    tight = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "t_eval": at}
    a, b = ours.solve(t_span, **tight), written.solve(t_span, **tight)
    assert a.success and [s.name for s in ours.states] == [s.name for s in written.states]
    assert np.abs(a.y - b.y).max() <= 1e-7 * np.abs(b.y).max()
    mine, theirs = a.quantities() | a.invariants(), b.quantities() | b.invariants()
    for here, there in SAME[name][1].items():
        assert mine[here] == pytest.approx(theirs[there], rel=1e-6, abs=1e-7)
    assert set(ours.invariants) >= set(written.invariants) - {"growing"}
    if "energy" in written.invariants:
        mass = ours.m if written.name == "satellite" else 1.0
        off = mine["energy"] - mine["energy"][0] - mass * (theirs["energy"] - theirs["energy"][0])
        assert np.abs(off).max() <= 1e-9 * np.abs(mine["energy"]).max()
