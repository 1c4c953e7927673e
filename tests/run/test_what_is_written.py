"""Writes in an event that few look for reach what compiled functions read."""

import functools
import types

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate

import fastdyn

pytestmark = pytest.mark.filterwarnings("ignore")
SCIPY = tuple(map(int, scipy.__version__.split(".")[:2]))
SPAN, START = (0.0, 3.0), [1.5, 0.7]


def module():
    thing = types.ModuleType("settings")
    thing.g = 1.0
    return lambda: thing.g, lambda v: thing.__dict__.update(g=v)


def error_class():
    class Far(Exception):
        g = 1.0

    return lambda: Far.g, lambda v: setattr(Far, "g", v)


def tuple_class():
    class Pair(tuple):
        g = 1.0

    it = Pair()
    return lambda: type(it).g, lambda v: setattr(Pair, "g", v)


def keyword():
    helper = functools.partial(lambda v, g: g + 0.0 * v, g=1.0)
    return lambda: helper(0.5), lambda v: helper.keywords.update(g=v)


def interpolator():
    table = scipy.interpolate.Akima1DInterpolator([0.0, 1.0, 2.0, 4.0], [1.0] * 4)

    def write(v):
        table.c = 0.0 * table.c
        table.c[-1] = v

    return lambda: float(table(0.5)), write


def code():
    def helper():
        return 1.0

    def low():
        return 0.3

    def high():
        return 1.7

    def write(v):
        helper.__code__ = (low if v < 1 else high).__code__

    return lambda: helper(), write


def defaults():
    def helper(g=1.0):
        return g

    def write(v):
        helper.__defaults__ = (v,)

    return lambda: helper(), write


def deleted():
    class Model:
        g = 0.3

    it = Model()

    def write(v):
        if v < 1:
            vars(it).pop("g", None)
        else:
            it.g = v

    return lambda: it.g, write


def polynomial():
    line = np.poly1d([1.0, 0.5])

    def write(v):
        line.c[:] = v

    return lambda: float(line(0.5)), write


PLACES = [
    module, error_class, tuple_class, keyword, interpolator, code, defaults, deleted, polynomial,
]  # fmt: skip


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("method", ["RK45", "DOP853"])
def test_what_an_event_writes_is_read(place, method):
    found = []
    for solve in scipy.integrate.solve_ivp, fastdyn.solve_ivp:
        read, write = place()

        def fun(t, y, read=read):
            return [-read() * y[0], y[0] - y[1]]

        def event(t, y, write=write):
            write(1.7 if t > 1 else 0.3)
            return t - 1.0

        for each in fun, event:  # code of its own: what is known of other places says nothing
            each.__code__ = each.__code__.replace(co_name=f"{place.__name__}_{method}")
        found.append(solve(fun, SPAN, START, method, events=event).y)
    theirs, ours = found
    assert np.allclose(ours[:, -1], theirs[:, -1], rtol=1e-9)


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "BDF", "Radau", "LSODA"])
@pytest.mark.parametrize("start", [list, np.array])
def test_an_event_that_writes_to_the_state(method, start):
    def event(t, y):
        y[0] -= 0.01
        return t - 1.0

    def fun(t, y):
        return [-y[0], y[0] - y[1]]

    given = start(START)
    ours = fastdyn.solve_ivp(fun, SPAN, given, method, events=event)
    assert list(given) == START
    if method == "LSODA" and SCIPY < (1, 17):
        start = list  # the Fortran code of earlier SciPy goes on from the given array itself
    theirs = scipy.integrate.solve_ivp(fun, SPAN, start(START), method, events=event)
    assert np.allclose(ours.y, theirs.y, rtol=1e-9, atol=1e-12) and ours.nfev == theirs.nfev


def test_an_event_that_bounces_has_its_effects_once():
    def solved(solve):
        state = {"hit": False}

        def event(t, y):
            if y[0] < 0 and not state["hit"]:
                state["hit"], y[1] = True, -y[1]
            return y[0]

        return solve(lambda t, y: [y[1], -9.8], (0, 2), [1.0, 0.0], events=event, max_step=0.01).y

    theirs, ours = solved(scipy.integrate.solve_ivp), solved(fastdyn.solve_ivp)
    assert np.allclose(ours[:, -1], theirs[:, -1], rtol=1e-9)


def test_effects_before_scipy_takes_over_are_no_secret():
    late = {"n": 0}

    def event(t, y):
        late["n"] += 1
        if late["n"] > 5:
            y[0] = 1.0
        return y[0] - 0.5

    with pytest.raises(ValueError, match=r"take scipy\.integrate"):
        fastdyn.solve_ivp(lambda t, y: [-y[0]], (0, 3), [1.0], events=event, max_step=0.1)
