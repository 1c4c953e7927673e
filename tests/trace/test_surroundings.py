"""What changes outside a traced function, what it stores there, and what NumPy does otherwise."""

import collections
import dataclasses
import enum
import functools
import types

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from support.beside_scipy import START, agrees

pytestmark = pytest.mark.filterwarnings("ignore")


class Holder:
    def __init__(self, k):
        self.k = k


def test_one_thing_under_two_names_that_part():
    one, two = Holder(1.0), Holder(5.0)
    s = types.SimpleNamespace(a=one, b=one)

    def fun(t, y):
        return [s.a.k * y[0], s.b.k * y[1]]

    agrees(fun)
    s.a = two
    agrees(fun)


def test_two_functions_that_shared_a_variable():
    def pair(k):
        return lambda x: k * x, lambda x: k * x

    a, b = pair(1.0)

    def fun(t, y):
        return [a(y[0]), b(y[1])]

    agrees(fun)
    a = pair(4.0)[0]
    agrees(fun)


def test_an_attribute_that_a_function_gets():
    def fun(t, y):
        return y * getattr(fun, "k", 1.0)

    agrees(fun)
    fun.k = 3.0
    agrees(fun)


@pytest.mark.parametrize("what", ["function", "class", "module", "slot", "object of the class"])
def test_effects_are_not_lost(what):
    class Model:
        count, inner = 0, Holder(0)

    class Slotted:
        __slots__ = ("count",)

    def function():
        return None

    target = {
        "function": function, "class": Model, "module": types.ModuleType("other"),
        "slot": Slotted(), "object of the class": Model.inner,
    }[what]  # fmt: skip
    target.count = 0
    model = Model()

    def fun(t, y):
        if what == "object of the class":
            model.inner.count = t
        else:
            target.count = t
        return -y

    fastdyn.solve_ivp(fun, (0.0, 1.0), START)
    mine = target.count
    reference(fun, (0.0, 1.0), START)
    assert type(mine) in (float, np.float64)
    assert mine == target.count


def test_a_bound_method_of_a_list():
    seen = []
    push = seen.append

    def fun(t, y):
        push(t)
        return -y

    fastdyn.solve_ivp(fun, (0.0, 1.0), START)
    assert all(isinstance(t, float) for t in seen)
    assert len(seen) > 5


def test_an_object_of_the_class():
    class Model:
        inner, table = Holder(1.0), ([1.0],)

        def fun(self, t, y):
            return [self.inner.k * y[0], self.table[0][0] * y[1]]

    model = Model()
    agrees(model.fun)
    Model.inner.k, Model.table[0][0] = 3.0, 2.0
    agrees(model.fun)


def test_a_descriptor():
    class Described:
        def __init__(self):
            self.k = 1.0

        def __get__(self, thing, kind):
            return self.k

    class Model:
        k = Described()

        def fun(self, t, y):
            return self.k * y

    model = Model()
    agrees(model.fun)
    vars(Model)["k"].k = 3.0
    agrees(model.fun)


def test_slots():
    @dataclasses.dataclass(slots=True)
    class P:
        k: float

    p = P(1.0)

    def fun(t, y):
        return p.k * y * (2 if hasattr(p, "z") else 1)

    agrees(fun)
    p.k = 3.0
    agrees(fun)


def test_variables_that_come_later():
    def made():
        def fun(t, y):
            try:
                return y * k
            except NameError:
                return y

        def fill(value):
            nonlocal k
            k = value

        if False:
            k = 0
        return fun, fill

    fun, fill = made()
    agrees(fun)
    fill(3.0)
    agrees(fun)

    def other(t, y):
        try:
            return y * LATE  # pyright: ignore
        except NameError:
            return y

    agrees(other)
    globals()["LATE"] = 3.0
    try:
        agrees(other)
    finally:
        del globals()["LATE"]


def test_names_that_a_class_in_the_function_looks_up():
    def fun(t, y):
        class Local:
            k = RATE * round(2.6)  # pyright: ignore  # noqa: F821

        return -Local.k * y

    globals()["RATE"] = 1.0
    try:
        agrees(fun)
        globals()["RATE"] = 0.5
        agrees(fun)
        globals()["round"] = lambda v: 1.0
        agrees(fun)
    finally:
        del globals()["RATE"]
        globals().pop("round", None)


def test_partials_with_more_arguments():
    def scaled(t, y, k, m=1.0):
        return k * m * y

    agrees(functools.partial(scaled, k=2.0))
    agrees(functools.partial(scaled, k=2.0, m=0.5))


def test_named_tuples_and_enums_with_members_of_their_own():
    class Pair(collections.namedtuple("Pair", "a b")):
        scale = 1.0

    class Body(enum.Enum):
        EARTH = 1

    p, Body.EARTH.k = Pair(1.0, 2.0), 1.0

    def fun(t, y):
        return p.scale * Body.EARTH.k * y

    agrees(fun)
    Pair.scale = 2.0
    agrees(fun)
    Body.EARTH.k = 0.3
    agrees(fun)


def test_whole_numbers_that_no_float_is():
    def fun(t, y, k):
        return [y[0] * (k % 7), -y[1]]

    agrees(fun, 2)
    for k in (2**54 + 1, -(2**54) - 1, 2**70 + 1, np.int64(-(2**63)), 2):
        agrees(fun, k)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_long_constant_beside_an_event_in_python():
    """The constant is an array stored beside the code, and the event may change what `fun` uses."""
    gain = np.ones(3)

    def fun(t, y):
        return np.linspace(0.1, 1.0, 130) * (1.0 - y) * gain.mean()

    def half(t, y):
        gain[:] = 2.0
        return y[-1] - 0.5

    mine, theirs = (
        solve(fun, (0.0, 2.0), np.zeros(130), events=half)
        for solve in (fastdyn.solve_ivp, reference)
        if gain.fill(1.0) is None
    )
    assert np.allclose(mine.t_events[0], theirs.t_events[0], rtol=1e-12)
    assert np.allclose(mine.y, theirs.y, rtol=1e-12)
