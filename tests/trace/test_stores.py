"""Functions that write to things outside run in Python: what they leave, and what is said."""

import types

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from support.unsaid import unsaid

pytestmark = pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
LATEST: dict = {}
force = 0.0


class Plant:
    def __init__(self):
        self.u, self.n, self.held = 0.0, 0, None
        self.table, self.matrix, self.list = {}, np.zeros((2, 2)), [0.0, 0.0]


def attributes(p):
    def control(t, y):
        p.error = 1.0 - y[0]
        p.u = max(-2.0, min(2.0, 3.0 * p.error - p.gain * y[1]))
        return p.u

    def fun(t, y):
        p.gain = 1.0 if t < 0.5 else 2.0
        return [y[1], control(t, y) - 0.1 * p.u]

    return fun


def items(p):
    def fun(t, y):
        p.table["e"] = y[0] * t
        p.list[1] = p.table["e"] + y[1]
        return [y[1], -p.list[1] - y[0]]

    return fun


def arrays(p):
    def fun(t, y):
        p.matrix[0, 0] = p.matrix[1, 1] = 2.0 + np.cos(y[0])
        p.matrix[0, 1] = p.matrix[1, 0] = 0.5
        return np.linalg.solve(p.matrix, [y[1], -y[0]])

    return fun


def a_global(p):
    def fun(t, y):
        global force
        force = -y[0] - 0.1 * y[1]
        LATEST["t"] = t
        return [y[1], force]

    return fun


def other_objects(p):
    bodies = [types.SimpleNamespace(x=None, m=m) for m in (1.0, 2.0)]
    p.bodies = bodies

    def fun(t, y):
        for body, x in zip(bodies, y, strict=True):
            body.x = x
        return [sum(b.m * b.x for b in bodies), -bodies[0].x]

    return fun


WRITTEN_FIRST = attributes, items, arrays, a_global, other_objects


def counts(p):
    def fun(t, y):
        p.n += 1
        return [y[1], -y[0]]

    return fun


def now_and_then(p):
    def fun(t, y):
        if t < 0.5:
            p.u = t
        return [y[1], -y[0] - 0.1 * p.u]

    return fun


def of_before(p):
    def fun(t, y):
        before, p.u = p.u, y[0]
        return [y[1], -y[0] - 0.1 * before]

    return fun


def the_first_time(p):
    def fun(t, y):
        first = 1.0 if p.held is None else 0.0
        p.held = y[0]
        return [y[1], -y[0] - first]

    return fun


def whether_it_is_there(p):
    def fun(t, y):
        there = float("k" in p.table) + float(hasattr(p, "new")) + len(p.table)
        p.table["k"] = p.new = y[0]
        return [y[1], -y[0] - 0.1 * there]

    return fun


def part_of_an_array(p):
    def fun(t, y):
        p.matrix[0] = y
        return [y[1], -p.matrix.sum()]

    return fun


def exchanged(p):
    def fun(t, y):
        p.u, p.n = y[0], p.u
        return [y[1], -y[0] - 0.1 * p.n]

    return fun


READ_FIRST = (
    counts, now_and_then, of_before, the_first_time, whether_it_is_there, part_of_an_array,
    exchanged,
)  # fmt: skip


def everything(plant):
    found = {"force": force, **LATEST}
    for name, value in vars(plant).items():
        if name == "bodies":
            found[name] = [b.x for b in value]
        elif name == "table":
            found |= value
        elif value is not None:
            found[name] = value
    return {name: np.array(value, float) for name, value in found.items()}


def solved(solve, make, method="RK45", **options):
    """The ends of two solves, and what they leave."""
    global force
    force = 0.0
    LATEST.clear()
    plant = Plant()
    fun = make(plant)
    ends = [solve(fun, (0, tf), [1.0, 0.5], method, **options).y[:, -1] for tf in (2.0, 1.5)]
    return np.array(ends), everything(plant)


def agrees(make, method="RK45", **options):
    theirs = solved(scipy.integrate.solve_ivp, make, method, **options)
    mine = solved(fastdyn.solve_ivp, make, method, **options)
    np.testing.assert_allclose(mine[0], theirs[0], 1e-7)
    assert mine[1].keys() == theirs[1].keys()
    for name, value in theirs[1].items():
        np.testing.assert_allclose(mine[1][name], value, 1e-6, 1e-9, err_msg=name)


@pytest.mark.parametrize("make", WRITTEN_FIRST + READ_FIRST)
def test_what_is_left(make):
    agrees(make)


CHANGED = {
    attributes: "an attribute", items: "a dict", arrays: "an array", a_global: "a global variable",
    other_objects: "an attribute", counts: "an attribute",
}  # fmt: skip


@pytest.mark.parametrize("make", CHANGED)
def test_what_is_said(make, monkeypatch):
    """One warning, which names what is changed, and where."""
    unsaid(monkeypatch)
    fun = make(Plant())
    with pytest.warns(fastdyn.CompileWarning) as said:
        for _ in range(2):
            fastdyn.solve_ivp(fun, (0, 2.0), [1.0, 0.5])
    (one,) = {str(each.message) for each in said}
    assert f"it changes {CHANGED[make]}" in one and "test_stores.py, line" in one


@pytest.mark.parametrize("method", ["RK23", "DOP853", "Radau", "BDF", "LSODA"])
@pytest.mark.parametrize("dense", [False, True])
def test_what_is_left_is_what_the_last_call_leaves(method, dense):
    agrees(attributes, method, dense_output=dense)


def test_an_event_sees_what_was_written():
    def solve(solver):
        plant = Plant()
        return solver(attributes(plant), (0, 3), [1.0, 0.5], events=lambda t, y: plant.u - 0.3)

    theirs, mine = solve(scipy.integrate.solve_ivp), solve(fastdyn.solve_ivp)
    np.testing.assert_allclose(mine.t_events[0], theirs.t_events[0], 1e-6)


def test_a_stepper_writes_at_each_step():
    plant = Plant()
    stepper = fastdyn.Stepper(attributes(plant), 0.0, [1.0, 0.5], 2.0, "RK45")
    for _ in range(3):
        stepper.step()
        assert plant.error == pytest.approx(1.0 - stepper.y[0])
