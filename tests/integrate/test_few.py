"""Functions of few evaluations stay in Python, where SciPy's odeint solves faster."""

import threading

import numpy as np
import pytest
import scipy.integrate

from fastdyn import CompileWarning, odeint
from fastdyn.integrate import few
from fastdyn.integrate.odeint import OdeintCall

pytestmark = pytest.mark.usefixtures("patience")
T = np.linspace(0, 10, 101)


def spring(y, t, k=1.0):
    return [y[1], -k * y[0]]


def new(fun):
    """The function with code of its own."""
    copy = type(fun)(
        fun.__code__.replace(co_firstlineno=new.line), globals(), None, fun.__defaults__
    )
    new.line += 1
    return copy


new.line = 1


@pytest.fixture
def compilations(monkeypatch):
    """The calls whose functions were compiled."""
    found = []
    was = OdeintCall.is_compiled
    monkeypatch.setattr(OdeintCall, "is_compiled", lambda call: found.append(call) or was(call))
    return found


def theirs(fun, *given, **options):
    return scipy.integrate.odeint(fun, *given, **options)


def test_few_evaluations_are_scipys(compilations):
    fun = new(spring)
    found, told = odeint(fun, [1, 0], T, (2.0,), full_output=True)
    rows, told_by_scipy = theirs(fun, [1, 0], T, (2.0,), full_output=True)
    assert (found == rows).all()
    assert told["message"] == told_by_scipy["message"]
    assert (told["nfe"] == told_by_scipy["nfe"]).all()
    given = np.array([1.0, 0.0])
    assert (odeint(fun, given, T) == theirs(fun, given, T)).all()
    assert (given == [1.0, 0.0]).all()
    assert not compilations


def test_a_function_of_many_solves_is_compiled(compilations, monkeypatch):
    monkeypatch.setattr(few, "MOST", 2000)
    fun = new(spring)
    found = [odeint(fun, [1, 0], T)[-1] for _ in range(20)]
    assert len(compilations) == 1
    np.testing.assert_allclose(found, [found[0]] * 20, rtol=1e-7)


@pytest.mark.parametrize("args", [(), (2.0,)])
def test_a_long_solve_is_compiled_on_the_way(compilations, monkeypatch, args):
    monkeypatch.setattr(few, "MOST", 200)
    t = np.linspace(0, 300, 501)
    fun = new(spring)
    found = odeint(fun, [1, 0], t, args)
    assert len(compilations) == 1
    assert few.spent_of(fun, False).n < 1000  # of some 7000
    wanted = theirs(fun, [1, 0], t, args)
    exact = np.cos(np.sqrt(*args or (1.0,)) * t)
    assert abs(found - wanted).max() < abs(wanted[:, 0] - exact).max()


def test_a_solve_near_its_end_is_not_compiled(compilations, monkeypatch):
    fun = new(spring)
    t = np.linspace(0, 30, 501)
    _, told = theirs(fun, [1, 0], t, full_output=True)
    monkeypatch.setattr(few, "MOST", int(told["nfe"][-1] * 0.9))
    assert (odeint(fun, [1, 0], t) == theirs(fun, [1, 0], t)).all()
    assert not compilations


def test_effects_happen_once_each(compilations, monkeypatch):
    monkeypatch.setattr(few, "MOST", 200)
    seen = []

    def records(y, t):
        seen.append(t)
        return [y[1], -y[0]]

    t = np.linspace(0, 100, 501)
    with pytest.warns(CompileWarning, match="records cannot .* changes a list"):
        found = odeint(records, [1, 0], t)
    ours = list(seen)
    seen.clear()
    assert (found == theirs(records, [1, 0], t)).all()
    assert ours == seen
    assert len(compilations) < 5  # the next trial is ever farther


def test_a_warning_names_the_line_of_the_function(monkeypatch):
    """Where no operation shows the reason, but what the function returns or holds."""
    monkeypatch.setattr(few, "MOST", 0)

    class Kept:
        out = np.zeros(2)

        def rates(self, y, t):
            self.out[:] = [y[1], -y[0]]
            return self.out

    kept = Kept()
    line = Kept.rates.__code__.co_firstlineno
    with pytest.warns(CompileWarning, match=rf"changes an array \(.*test_few.py, line {line}\)"):
        odeint(kept.rates, [1, 0], np.linspace(0, 1, 5))


def test_an_exception_is_raised_once_with_its_note():
    times = []

    def raises(y, t):
        times.append(t)
        return [y[1], {}["k"]] if t > 1 else [y[1], -y[0]]

    t = np.linspace(0, 10, 501)
    for times_given in (T, t):  # fewer evaluations, and a number that is counted
        times.clear()
        with pytest.raises(KeyError, match="k"):
            odeint(raises, [1, 0], times_given)
    assert sum(time > 1 for time in times) == 1
    with pytest.raises(TypeError) as info:
        odeint(new(spring), [1, 0], t, (1.0, 2.0))
    assert "called as fun(y, t, *args)" in info.value.__notes__[0]


def test_a_failure_has_its_reason_and_no_numbers():
    with pytest.warns(scipy.integrate.ODEintWarning, match="Excess work.*raise `mxstep`"):
        found = odeint(new(spring), [1, 0], [0, 1, 1000], mxstep=100)
    assert np.isfinite(found[:2]).all()
    assert np.isnan(found[2]).all()


def test_a_solve_within_a_solve():
    inner = new(spring)

    def outer(y, t):
        return -y * odeint(inner, [1, 0], [0, 1])[-1, 0]

    found = odeint(outer, 1.0, [0.0, 1.0])
    assert abs(found[-1, 0] - np.exp(-np.cos(1.0))) < 1e-6


def test_a_solve_beside_another():
    """The second does not wait for the first, which is within SciPy's code."""
    began, ends = threading.Event(), threading.Event()
    found = []

    def waits(y, t):
        began.set()
        assert ends.wait(timeout=60)
        return -y

    first = threading.Thread(target=lambda: found.append(odeint(waits, 1.0, [0.0, 1.0])[-1, 0]))
    first.start()
    assert began.wait(timeout=60)
    found.append(odeint(new(spring), [1, 0], [0, 1])[-1, 0])
    ends.set()
    first.join()
    np.testing.assert_allclose(found, [np.cos(1.0), np.exp(-1.0)], rtol=1e-6)
