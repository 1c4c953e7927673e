"""Code is compared at the ends of accepted steps, the shortest among them, whatever the output."""

import itertools

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.kernels.state.snapshot_table import SIZE, STATE, TIME
from fastdyn.run.functions import compared
from fastdyn.specialise.series import NoSeries
from fastdyn.trace.graph.rows import Rows

METHODS = ["RK45", "DOP853", "Tsit5", "Vern9", "LSODA", "BDF", "Radau", "Rodas5P", "Taylor"]
OUTPUTS = [{"t_eval": [10.0]}, {"dense_output": True}, {"events": lambda t, y: t - 4.0}, {}]
SAID = r"compiled form gives .* and Python"


_numbers = itertools.count(1)


def pulse():
    """A function whose code no other test has compared: a pulse at t = 7.3."""
    at = 7.3 + 1e-6 * next(_numbers)
    return eval(f"lambda t, y: [y[1], -y[0] - 3 * np.exp(-(((t - {at}) / 0.2) ** 2))]")


@pytest.fixture
def blind(monkeypatch):
    """A first comparison that sees nothing."""
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)


@pytest.fixture
def runs(monkeypatch):
    """The snapshots of each solve, or None."""
    found, after = [], compared.Compared.after

    def noted(self, run):
        found.append(None if run.snapshots is None else compared.taken(run).copy())
        after(self, run)

    monkeypatch.setattr(compared.Compared, "after", noted)
    return found


@pytest.mark.few(6)
@pytest.mark.parametrize(("method", "output"), [*itertools.product(METHODS, range(4))])
def test_code_that_is_wrong_in_a_pulse_is_found(method, output, wrong_products, blind):
    given = pulse(), (0, 10), [1.0, 0.0]
    options = {"method": method, "max_step": 0.05, "rtol": 1e-6, "atol": 1e-8}
    if method == "Taylor":  # which has no way in Python
        with pytest.raises(NoSeries, match=SAID):
            fastdyn.solve_ivp(*given, **options, **OUTPUTS[output])
        return
    with pytest.warns(fastdyn.CompileWarning, match=SAID):
        mine = fastdyn.solve_ivp(*given, **options, **OUTPUTS[output])
    theirs = scipy.integrate.solve_ivp(*given, rtol=1e-9, atol=1e-9, max_step=0.05)
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=0, atol=1e-4)


def test_a_later_solve_that_is_due_is_compared_in_the_pulse(wrong_products, blind):
    def fun(t, y, t0):
        return [y[1], -y[0] - 3 * np.exp(-(((t - t0) / 0.2) ** 2))]

    away = -100.0  # the pulse of the first solves, where code and function are equal
    solver = fastdyn.prepare(fun, (0, 10), [1.0, 0.0], args=(away,), t_eval=[10.0], max_step=0.5)
    for _ in range(7):  # the compared solves are 1, 2, 4, 8
        solver(args=(away,))
    with pytest.warns(fastdyn.CompileWarning, match=SAID):
        mine = solver(args=(7.3137,))
    theirs = scipy.integrate.solve_ivp(fun, (0, 10), [1.0, 0.0], args=(7.3137,), max_step=0.5)
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-12, atol=0)


@pytest.mark.parametrize("method", METHODS)
def test_snapshots_do_not_depend_on_the_output_and_change_nothing(method, runs, monkeypatch):
    given, ends = (pulse(), (0, 10), [1.0, 0.0], method), []
    monkeypatch.setattr(compared, "WHEN", "always")
    for output in OUTPUTS:
        ends.append(fastdyn.solve_ivp(*given, **output).y[:, -1])
    monkeypatch.setattr(compared.Compared, "places", lambda compared: 0)
    steps = fastdyn.solve_ivp(*given)
    *tables, none = runs
    assert none is None and all(np.array_equal(end, steps.y[:, -1]) for end in ends[1:])
    # At a time of t_eval, the end of a step is y_old + (y_new - y_old), rounded twice.
    rounding = 2 * np.finfo(float).eps * np.abs(steps.y[:, -2:]).max()
    assert np.abs(ends[0] - steps.y[:, -1]).max() <= rounding
    assert all(np.array_equal(table, tables[-1]) for table in tables)
    table = tables[-1]
    at = np.searchsorted(steps.t, table[:, TIME])
    assert np.array_equal(steps.t[at], table[:, TIME])
    assert np.array_equal(steps.y[:, at].T, table[:, STATE:])
    sizes = np.diff(steps.t)
    assert np.array_equal(table[:, SIZE], sizes[at - 1])
    assert table[:, SIZE].min() <= sizes.min() / 0.8
    assert len(table) >= min(len(sizes), compared.PLACES // 2)


@pytest.mark.parametrize("n_steps", [1, 2, 5, 31, 32, 33, 64, 1000])
def test_intervals_of_constant_steps_are_as_long_as_they_must_be(n_steps, runs):
    fun, step = eval(f"lambda t, y: [y[1], -y[0] * {1.0 + 2.0**-20 * n_steps}]"), 2.0**-6
    fastdyn.solve_ivp(fun, (0, n_steps * step), [1.0, 0.0], "RK4", step=step, t_eval=[0.0])
    (table,) = runs
    steps = table[:, TIME] / step
    stride = max(1, 2 ** int(np.ceil(np.log2(n_steps / compared.PLACES))))
    assert np.array_equal(steps, np.arange(1, n_steps + 1, stride))


@pytest.mark.parametrize("n", [3, 100])
def test_code_that_is_wrong_at_the_start_is_told(n, wrong_products, monkeypatch):
    fun, make = eval(f"lambda t, y: 3 * np.tanh(y[::-1]) - {4 + n / 1024} * y"), Rows.row

    def wrong(graph, op, *given, **more):
        return make(graph, "sin" if op == "tanh" else op, *given, **more)

    monkeypatch.setattr(Rows, "row", wrong)  # for long arrays

    y0 = np.linspace(0.1, 1.0, n)
    with pytest.warns(fastdyn.CompileWarning, match=rf"(?s)y = .*{SAID}"):
        mine = fastdyn.solve_ivp(fun, (0, 1), y0)
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), y0)
    assert np.allclose(mine.y, theirs.y, rtol=1e-12, atol=0)
