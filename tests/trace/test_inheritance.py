"""Methods that call `super()`, and values of classes that derive from lists, tuples and numbers."""

import abc
import dataclasses
import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near

pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.usefixtures("no_comparisons")]


class Spring:
    k = 1.0

    def __init__(self, mass):
        self.mass = mass

    def __call__(self, t, y):
        return [y[1], -self.k * y[0] / self.mass + self.push(t)]

    def push(self, t):
        return 0.0

    @property
    def rate(self):
        return 0.1 * self.mass

    @classmethod
    def scaled(cls, x):
        return cls.k * x


class Damped(Spring):
    k = 2.0

    def __call__(self, t, y):
        a, b = super().__call__(t, y)
        return [a, b - self.rate * y[1]]

    @property
    def rate(self):
        return super().rate + self.scaled(0.05)

    @classmethod
    def scaled(cls, x):
        return super().scaled(x) + 0.01


class Pushed(Spring):
    def push(self, t):
        return super().push(t) + 0.3 * t


class Louder(Spring):
    def push(self, t):
        return 2.0 * super().push(t) + 0.5


class Diamond(Pushed, Louder):
    def push(self, t):
        return super().push(t) - 1.0


class Skips(Diamond):
    def push(self, t):
        return super(Diamond, self).push(t)


class Silent(Damped):
    push = Spring.push
    rate = None  # hides the property
    k = 3

    def __call__(self, t, y):
        return Spring.__call__(self, t, y) if self.rate is None else [0.0, 0.0]


class Nested(Damped):
    def __call__(self, t, y):
        above = super()
        return [above.__call__(t, y)[i] for i in range(2)]


class Law(abc.ABC):
    @abc.abstractmethod
    def force(self, x): ...

    def __call__(self, t, y):
        return [y[1], self.force(y[0])]


class Cubic(Law):
    def force(self, x):
        return -x if x < 0 else -(x**3)


@dataclasses.dataclass
class Load:
    mass: float = 1.0

    def force(self, x):
        return -self.mass * x


@dataclasses.dataclass
class MoreLoad(Load):
    more: float = 0.25

    def force(self, x):
        return super().force(x) - self.more


class Slots:
    __slots__ = ("a",)

    def __init__(self, a):
        self.a = a

    def rates(self, t, y):
        return [y[1], -self.a * y[0]]


class MoreSlots(Slots):
    __slots__ = ("b",)

    def __init__(self, a, b):
        super().__init__(a)
        self.b = b

    def rates(self, t, y):
        a, b = super().rates(t, y)
        return [a, b + self.b]


def made_inside(t, y):
    return MoreSlots(1.2, y[1]).rates(t, y)


class Doubles:
    def __setattr__(self, name, value):
        super().__setattr__(name, 2.0 * value)


def set_inside(t, y):
    made = Doubles()
    made.k = 1.5
    return [y[1], -made.k * y[0]]


class Raised(dict):
    def __getitem__(self, key):
        return super().__getitem__(key) + 1.0


class Unequal:
    def __init__(self, v):
        self.v = v

    def __eq__(self, other):
        return not super().__eq__(other)

    __hash__ = None


LOAD = MoreLoad()
RAISED = Raised(k=0.5)
UNEQUAL = Unequal(1.0)
TRACED = {
    "damped": Damped(1.5), "diamond": Diamond(1.2), "skips": Skips(1.1), "silent": Silent(1.1),
    "nested": Nested(0.9), "abc": Cubic(), "slots": MoreSlots(1.1, 0.3).rates,
    "dataclass": lambda t, y: [y[1], LOAD.force(y[0])],
    "unbound": functools.partial(Damped.__call__, Nested(1.3)), "made inside": made_inside,
    "set inside": set_inside, "dict": lambda t, y: [y[1], -RAISED["k"] * y[0]],
    "equal": lambda t, y: [y[1], -(3.0 if UNEQUAL == UNEQUAL else 1.0) * y[0]],
}  # fmt: skip


def agree(fun):
    mine, theirs = (f(fun, (0.0, 2.0), [1.0, 0.5]) for f in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("name", TRACED)
def test_super_is_traced(name):
    agree(TRACED[name])
    near = Near(0.0, 2.0, np.array([1.0, 0.5]))
    assert bind(TRACED[name], (), DERIVATIVE, 2, near).function.traced is not None


@pytest.mark.parametrize("name", ["damped", "diamond", "nested"])
def test_a_changed_base_is_seen(name, monkeypatch):
    agree(TRACED[name])
    monkeypatch.setattr(Spring, "k", 3.5)
    agree(TRACED[name])
    monkeypatch.setattr(Spring, "push", lambda self, t: 0.7)
    agree(TRACED[name])
    monkeypatch.setattr(Damped, "push", lambda self, t: -0.7, raising=False)
    agree(TRACED[name])


class Shifted(list):
    def __getitem__(self, i):
        return super().__getitem__(i) + 1.0


class Longer(list):
    def __len__(self):
        return 5


class Second(tuple):
    __slots__ = ()

    def __getitem__(self, i):
        return super().__getitem__(-1 - i)


class Half(float):
    def __mul__(self, other):
        return 0.5 * float(self) * other


SHIFTED, LONGER, SECOND, HALF = Shifted([1.0, 2.0]), Longer([1.0]), Second((1.0, 2.0)), Half(3.0)
DERIVED = [
    lambda t, y: [y[1], -SHIFTED[1] * y[0]],
    lambda t, y: [y[1], -len(LONGER) * y[0]],
    lambda t, y: [y[1], -SECOND[0] * y[0]],
    lambda t, y: [y[1], -(HALF * 2.0) * y[0]],
]


@pytest.mark.parametrize("fun", DERIVED)
def test_a_class_that_derives_from_a_list_or_a_number_keeps_its_functions(fun):
    agree(fun)
