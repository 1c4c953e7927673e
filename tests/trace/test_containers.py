"""Parameters in dicts, lists and namespaces of a user's class, in models, in tables of pandas."""

import collections
import types

import numpy as np
import pandas as pd
import pytest
import scipy.integrate

import fastdyn

pytestmark = pytest.mark.filterwarnings("error::fastdyn.CompileWarning")


def agrees(fun, *args, y0=(1.0, 0.5)):
    theirs = scipy.integrate.solve_ivp(fun, (0, 3), list(y0), args=args, rtol=1e-6)
    mine = fastdyn.solve_ivp(fun, (0, 3), list(y0), args=args, rtol=1e-6)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], 1e-4)
    return mine.y[:, -1]


def differ(before, after):
    assert np.abs(before - after).max() > 1e-3


def of_a_series(s):
    def fun(t, y):
        last = s.iloc[1] * s.loc["n"] + s.get("none", 0.0) + len(s)
        return [y[1], -s["k"] * y[0] - s.c * y[1] * last]

    return fun, lambda: s.update(pd.Series({"k": 9.0}))


def of_a_frame(s):
    table = pd.DataFrame({"k": [1.0, 4.0], "c": [0.1, 0.2]}, index=["a", "b"])

    def fun(t, y):
        row = table.loc["b"]
        more = table["k"].values[0] + table.k.iloc[1] + table.iloc[0, 1] + table.at["a", "c"]
        return [y[1], -row["k"] * y[0] - row.c * y[1] * more]

    return fun, lambda: table.__setitem__("k", [1.0, 9.0])


def of_a_chain(s):
    base = {"k": 4.0}
    p = collections.ChainMap({"c": 0.2}, base)

    def fun(t, y):
        return [y[1], -p["k"] * y[0] - p["c"] * y[1]]

    return fun, lambda: base.update(k=9.0)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (of_a_series, "it uses pandas"), (of_a_frame, "it uses pandas"),
        (of_a_chain, "it uses an object of type ChainMap"),
    ],
)  # fmt: skip
def test_tables_of_other_libraries_are_read_in_python(make, why):
    fun, change = make(pd.Series({"k": 4.0, "c": 0.1, "n": 2}))
    with pytest.warns(fastdyn.CompileWarning, match=why):
        before = agrees(fun)
    change()
    differ(before, agrees(fun))


def test_columns_and_labels_are_compiled_once_they_are_taken_out():
    profile = pd.DataFrame({"time": np.arange(50.0) / 10, "I": np.sin(np.arange(50.0) / 20)})
    times, currents = profile["time"].to_numpy(), profile["I"].to_numpy().copy()

    def fun(t, y):
        return [np.interp(t, times, currents) - y[0], -y[1]]

    before = agrees(fun)
    currents *= 2
    differ(before, agrees(fun))


class Attributes(dict):
    def __getattr__(self, name):
        return self[name]

    def __setattr__(self, name, value):
        self[name] = value


class Itself(dict):
    def __init__(self, **given):
        super().__init__(**given)
        self.__dict__ = self


class Parameter:
    def __init__(self, value):
        self.value = value


class Parameters(dict):
    def values_dict(self):
        return {name: parameter.value for name, parameter in self.items()}

    def __getitem__(self, name):
        return dict.__getitem__(self, name).value


class Doubled(collections.UserDict):
    def twice(self, name):
        return 2 * self.data[name]


def test_dicts_of_users():
    for make in (Attributes, Itself):
        p = make(k=4.0, c=0.1)

        def fun(t, y, p):
            return [y[1], -p.k * y[0] - p["c"] * y[1]]

        before = agrees(fun, p)
        p["k"] = 9.0
        differ(before, agrees(fun, p))


def test_dicts_that_answer_otherwise():
    p = Parameters(k=Parameter(4.0), c=Parameter(0.1))

    def fun(t, y):
        return [y[1], -p["k"] * y[0] - p.values_dict()["c"] * y[1]]

    before = agrees(fun)
    dict.__getitem__(p, "k").value = 9.0
    differ(before, agrees(fun))


def test_a_user_dict():
    doubled = Doubled(c=0.1)

    def fun(t, y):
        return [y[1], -4.0 * y[0] - y[1] * doubled.twice("c")]

    before = agrees(fun)
    doubled["c"] = 5.0
    differ(before, agrees(fun))


class Numbers(list):
    def mean(self):
        return sum(self) / len(self)


class Settings(types.SimpleNamespace):
    def rate(self):
        return self.k * self.parts["a"].value


def test_classes_that_derive_from_a_list_or_a_namespace():
    few, many = Numbers([1.0, 3.0]), Numbers(np.linspace(0.1, 0.2, 40).tolist())
    s = Settings(k=2.0, parts={"a": Parameter(2.0)})

    def fun(t, y):
        return [y[1], -s.rate() * y[0] * few.mean() - y[1] * many.mean() * many[int(t)] * few[0]]

    before = agrees(fun)
    s.k = 5.0
    changed = agrees(fun)
    differ(before, changed)
    s.parts["a"].value, few[1], many[0] = 3.0, 9.0, 7.0
    differ(changed, agrees(fun))
    few.append(1.0)
    agrees(fun)
    Numbers.mean = lambda self: 0.3
    agrees(fun)


class Registering(type):
    made: list = []  # noqa: RUF012

    def __new__(cls, name, bases, body):
        found = super().__new__(cls, name, bases, body)
        cls.made.append(found)
        return found


class Model(metaclass=Registering):
    def __init__(self, k, c):
        self.k, self.c = k, c

    @property
    def damping(self):
        return 2 * self.c

    def force(self, x):
        return -self.k * x


def test_a_class_that_sees_who_inherits():
    model, count = Model(4.0, 0.1), len(Registering.made)

    def fun(t, y):
        return [y[1], model.force(y[0]) - model.damping * y[1]]

    before = agrees(fun)
    model.k = 9.0
    differ(before, agrees(fun))
    assert len(Registering.made) == count


def test_polynomials():
    p, q = np.polynomial.Polynomial([1.0, -0.3, 0.02]), np.poly1d([0.1, -0.2, 0.3])

    def fun(t, y):
        return [p(y[0]) * 0.1 - y[0], q(y[1]) - y[1]]

    before = agrees(fun)
    p.coef[0] = 5.0
    differ(before, agrees(fun))
