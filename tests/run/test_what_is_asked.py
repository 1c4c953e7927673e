"""What is asked of time's type, of living things, of objects that answer anything, of caches."""

import abc
import functools
import gc
import weakref

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate

import fastdyn

pytestmark = pytest.mark.filterwarnings("ignore")
SPAN = (0.0, 3.0)


ASKED = {
    "class": lambda t: 2.0 if t.__class__ is float else 0.5,
    "type": lambda t: 2.0 if type(t) is float else 0.5,
    "identity": lambda t: 2.0 if t.__lt__(0.5) is True else 0.5,
}


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("method", ["RK45", "LSODA"])
def test_the_type_of_the_time(asked, method):
    def fun(t, y):
        return [-ASKED[asked](t) * y[0]]

    given = fun, SPAN, [1.0]
    theirs = scipy.integrate.solve_ivp(*given, method=method)
    shot = fastdyn.prepare(*given, method=method)
    for ours in fastdyn.solve_ivp(*given, method=method), shot([1.0]), shot([1.0]):
        assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_classes_that_inherit_are_those_of_the_user():
    class Part:
        rate = 0.5

    kept = [type(name, (Part,), {"rate": rate}) for name, rate in (("A", 0.4), ("B", 0.7))]

    def fun(t, y):
        return [-sum(c.rate for c in Part.__subclasses__()) * y[0] * len(kept[0].__name__)]

    theirs, ours = (f(fun, SPAN, [1.0]) for f in (scipy.integrate.solve_ivp, fastdyn.solve_ivp))
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_a_class_that_decides_what_belongs_to_it():
    """No copy of such a class is left among its subclasses, where isinstance() asks the copy."""

    class Shape(abc.ABC):  # noqa: B024
        @classmethod
        def __subclasshook__(cls, c):
            return True if "Square" in globals() else NotImplemented

    class Square:
        area = 2.0

    def fun(t, y):
        return [-y[0] if isinstance(thing, Shape) else -2.0 * y[0]]

    gc.disable()
    try:
        for thing in (Square(), 3.0, Square()):  # noqa: B007 - which `fun` reads
            given = fun, SPAN, [1.0]
            theirs, ours = scipy.integrate.solve_ivp(*given), fastdyn.solve_ivp(*given)
            assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)
    finally:
        gc.enable()


def test_a_state_in_python_is_an_array_as_numpy_makes_them():
    def fun(t, y):
        log.append(t)
        return [-memoryview(y)[0], -y[1]] if y.dtype is np.dtype(float) else [0.0, 0.0]

    log = []
    for method in ("RK45", "LSODA", "Radau"):
        theirs, ours = (
            f(fun, SPAN, [1.0, 2.0], method=method)
            for f in (scipy.integrate.solve_ivp, fastdyn.solve_ivp)
        )
        assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_what_dies_is_not_kept():
    class Part:
        rate = 0.5

    held = [Part()]
    look = weakref.ref(held[0])

    def fun(t, y):
        if t > 1:
            held.clear()
        return [-y[0] if look() is None else -look().rate * y[0]]

    gc.collect()
    ours = fastdyn.solve_ivp(fun, SPAN, [1.0])
    held.append(Part())
    look = weakref.ref(held[0])
    theirs = scipy.integrate.solve_ivp(fun, SPAN, [1.0])
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_what_dies_is_not_kept_by_the_trace_of_another_function():
    class Part:
        rate = 0.5

    held = [Part(), Part()]
    parts = weakref.WeakSet(held)

    def fun(t, y):
        return [-sum(part.rate for part in parts) * y[0]]

    def act(t, y):
        held.pop()
        return y

    r = fastdyn.solve_ivp(fun, (0, 2), [1.0], events=lambda t, y: t - 0.6, on_event=act, rtol=1e-8)
    assert abs(r.y[0, -1] - np.exp(-0.6 - 0.5 * 1.4)) < 1e-7


class Counted:
    n = 0

    def __getattr__(self, name):
        Counted.n += 1
        return 0.5

    @property
    def gain(self):
        Counted.n += 1
        return 0.5


@pytest.mark.parametrize("name", ["anything", "gain"])
def test_attributes_are_asked_for_as_often_as_in_python(name):
    thing, held = Counted(), memoryview(bytearray([1, 2]))

    def fun(t, y):
        return [-getattr(thing, name) * y[0] * held[0]]

    def direct(t, y):
        return [-thing.gain * y[0] * held[0]]

    Counted.n = 0
    found = fastdyn.solve_ivp(direct if name == "gain" else fun, SPAN, [1.0])
    assert Counted.n == found.nfev


class Anything(type):
    def __getattr__(cls, name):
        return 0.5


class Vague(metaclass=Anything):
    pass


def test_a_class_that_answers_anything():
    def made():
        kind = Vague

        def fun(t, y):
            return [-kind.rate * y[0] * len(str(y[0] > 9))]

        return fun

    theirs, ours = (f(made(), SPAN, [1.0]) for f in (scipy.integrate.solve_ivp, fastdyn.solve_ivp))
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_code_is_not_made_again_and_again(monkeypatch):
    table = scipy.interpolate.interp1d([0.0, 1.0, 9.0], [1.0, 0.5, 0.2])
    made = []

    def event(t, y):
        table.x = table.x * 1.01
        return t - 1.0

    from fastdyn.run.functions import followed

    bind = followed.bind
    monkeypatch.setattr(
        followed, "bind", lambda *a, **k: made.append(k.get("refused")) or bind(*a, **k)
    )
    fastdyn.solve_ivp(
        lambda t, y: [-float(table(0.5 * t)) * y[0]], SPAN, [1.0], events=event, max_step=0.05
    )
    assert (
        made.count(None) <= followed.MOST_MADE
        and len(made) == len(set(made)) + made.count(None) - 1
    )


def test_a_cache_of_the_user_is_filled_by_his_own_calls():
    def solved(solve):
        setting = {"g": 0.85}

        @functools.cache
        def helper(n):
            return setting["g"] * n

        def fun(t, y):
            setting["g"] = 2.0
            return [-helper(1) * y[0]]

        return solve(fun, SPAN, [1.0]).y[0, -1]

    assert np.isclose(solved(fastdyn.solve_ivp), solved(scipy.integrate.solve_ivp), rtol=1e-9)


def test_functions_that_gave_up_one_after_the_other_have_no_effects():
    def fun(t, y):
        v = int(100 * abs(2 * t)) / 200
        return [-(abs(round(v, 1)) + 0.3) * y[0]]

    def rate(t, y):
        return fun(t, y)[0] + len(str(y[0] > 9)) * 0.0

    events = [lambda t, y: fun(t, y)[0], rate]
    theirs, ours = (
        f(fun, SPAN, [1.0], events=events) for f in (scipy.integrate.solve_ivp, fastdyn.solve_ivp)
    )
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)
