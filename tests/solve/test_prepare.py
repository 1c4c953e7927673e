"""A prepared solver answers as solve_ivp does, to the last bit, whatever changes between calls."""

import threading
import types

import numpy as np
import pytest
from scipy.integrate import OdeSolver

from fastdyn import prepare, solve_ivp

SPAN = (0.0, 3.0)
START = [1.0, 0.0, 0.0, 1.0]
TIGHT = {"rtol": 1e-7, "atol": 1e-9}


def orbit(t, w, GM):
    x, y, vx, vy = w
    r = np.sqrt(x**2 + y**2)
    return [vx, vy, -GM * x / r**3, -GM * y / r**3]


def at_axis(t, w, GM):
    return w[1]


def shared(*given, **named):
    """A prepared solver that needs no kernel of its own."""
    return prepare(*given, compile="shared", **named)


def same(one, other):
    """Whether two results are equal to the last bit."""
    assert one.status == other.status and one.message == other.message
    assert (one.nfev, one.n_accepted, one.n_rejected) == (
        other.nfev, other.n_accepted, other.n_rejected,
    )  # fmt: skip
    assert np.array_equal(one.t, other.t) and np.array_equal(one.y, other.y)
    if other.t_events is not None:
        for mine, his in ((one.t_events, other.t_events), (one.y_events, other.y_events)):
            assert all(np.array_equal(a, b) for a, b in zip(mine, his, strict=True))
    if other.sol is not None:
        times = np.linspace(*SPAN, 17)
        assert np.array_equal(one.sol(times), other.sol(times))


def test_constant_steps():
    solver = prepare(orbit, SPAN, START, "VelocityVerlet", args=(1.0,), step=0.003)
    for GM in (1.0, 0.9):
        expected = solve_ivp(orbit, SPAN, START, "VelocityVerlet", args=(GM,), step=0.003)
        same(solver(args=(GM,)), expected)
        assert len(expected.t) > 1000  # in several pieces


def test_results_are_the_callers():
    solver = prepare(orbit, SPAN, START, args=(1.0,), events=at_axis, dense_output=True)
    plain = prepare(orbit, SPAN, START, args=(1.0,), t_eval=[1.0, 3.0])
    for prepared in (solver, plain):
        first = prepared()
        before = first.t.copy(), first.y.copy()
        first_sol = first.sol and first.sol(1.5)
        prepared([2, 0, 0, 0.5], (2.0,))
        assert np.array_equal(first.t, before[0]) and np.array_equal(first.y, before[1])
        if first.sol:
            assert np.array_equal(first.sol(1.5), first_sol)
        first.y[:] = np.nan
        first.t[:] = np.nan
        same(prepared(), solve_ivp_like(prepared))


def solve_ivp_like(prepared):
    p = prepared._problem
    return solve_ivp(
        p.fun, (p.t0, p.tf), p.y0, t_eval=p.t_eval, dense_output=p.dense_output, args=p.args,
        events=[event.function for event in p.events] if p.events else None,
    )  # fmt: skip


def test_arguments_of_other_kinds():
    def pull(t, y, k):
        return [y[1], -k * y[0]]

    def pulled(t, y, k):
        return [y[1], -k[0] * y[0] - k[-1] * y[1]]

    solver = shared(pull, SPAN, [1, 0], args=(2.0,))
    for k in (2.0, 3, np.float64(1.5), True, 2.0):
        same(solver(args=(k,)), solve_ivp(pull, SPAN, [1, 0], args=(k,)))
    k = np.array([1.0, 0.1])
    solver = shared(pulled, SPAN, [1, 0], args=(k,))
    for _ in range(3):
        same(solver(), solve_ivp(pulled, SPAN, [1, 0], args=(k,)))
        k *= 1.5  # in place
    for other in (np.ones(5), np.arange(8.0)[::2], (1.0, 2.0)):
        same(solver(args=(other,)), solve_ivp(pulled, SPAN, [1, 0], args=(other,)))


GRAVITY = 9.81


def test_what_changes_outside_is_seen(monkeypatch):
    drag = 0.1

    def fall(t, y):
        return [y[1], -GRAVITY - drag * y[1]]

    def landing(t, y):
        return y[0] - drag

    solver = shared(fall, SPAN, [1, 9], events=landing)
    same(solver(), solve_ivp(fall, SPAN, [1, 9], events=landing))
    drag = 0.5
    same(solver(), solve_ivp(fall, SPAN, [1, 9], events=landing))
    monkeypatch.setitem(globals(), "GRAVITY", 1.62)
    same(solver(), solve_ivp(fall, SPAN, [1, 9], events=landing))
    monkeypatch.setitem(globals(), "GRAVITY", 2)  # a whole number is part of the code
    same(solver(), solve_ivp(fall, SPAN, [1, 9], events=landing))


def test_new_code_in_the_same_function():
    def grow(t, y):
        return y

    def decay(t, y):
        return -y

    solver = shared(grow, SPAN, [1.0])
    assert solver().y[0, -1] > 1
    grow.__code__ = decay.__code__
    assert solver().y[0, -1] < 1
    scope = {"m": np}
    exec("def root(t, y): return m.sqrt(y)", scope)
    solver = shared(scope["root"], SPAN, [1.0])
    before = solver().y
    scope["m"] = types.SimpleNamespace(sqrt=np.cbrt)
    assert solver().y[0, -1] < before[0, -1] - 0.1
    scope["m"] = np
    assert np.array_equal(solver().y, before)


def test_after_a_failure():
    def root(t, y, a):
        return np.sqrt(a - y)

    def refuse(t, y, a):
        if y[0] > a:
            raise ValueError(f"{y[0] > a} for a = {a}")
        return [1.0]

    solver = shared(root, SPAN, [0.0], args=(10.0,))
    good = solver()
    bad = solver(args=(-1.0,))
    assert bad.status == -1 and bad.message == solve_ivp(root, SPAN, [0.0], args=(-1.0,)).message
    same(solver(), good)
    solver = shared(refuse, SPAN, [0.0], args=(5.0,))
    for a in (1.0, 2.0):
        with pytest.raises(ValueError, match=f"for a = {a}"):
            solver(args=(a,))
        same(solver(), solve_ivp(refuse, SPAN, [0.0], args=(5.0,)))


def test_a_function_that_stays_in_python():
    seen = []

    def pull(t, y, c):
        seen.append(t)
        return [y[1], -2.0 * y[0] - c * y[1]]

    with pytest.warns(match="runs in Python"):
        solver = shared(pull, SPAN, [1, 0], args=(0.1,))
    for c in (0.1, 0.5):
        same(solver(args=(c,)), solve_ivp(pull, SPAN, [1, 0], args=(c,)))


def test_threads():
    solver = prepare(orbit, (0, 50), START, args=(1.0,), t_eval=[25.0, 50.0], **TIGHT)
    speeds = np.linspace(0.8, 1.2, 40)
    expected = [solver([1, 0, 0, v]).y for v in speeds]
    found = {}

    def work(mine):
        for i in mine:
            found[i] = solver([1, 0, 0, speeds[i]], (1.0,)).y

    threads = [threading.Thread(target=work, args=(range(k, 40, 4),)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(found[i], expected[i]) for i in range(40))


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"method": OdeSolver}, ValueError, "fastdyn's methods"),
        ({"method": "RK5"}, ValueError, "is unknown"),
        ({"y0": [1j, 0]}, ValueError, "real state"),
        ({"y0": []}, ValueError, "real state"),
        ({"t_span": (1, 1)}, ValueError, "not empty"),
        ({"checkpoint": "x"}, TypeError, "no `checkpoint`"),
        ({"method": "RK4"}, ValueError, "`step`"),
    ],
)
def test_refused(given, error, said):
    arguments = {"fun": lambda t, y: -y, "t_span": SPAN, "y0": [1.0, 2.0]} | given
    with pytest.raises(error, match=said):
        prepare(**arguments)


def test_other_states_refused():
    solver = shared(lambda t, y: -y, SPAN, [1.0, 2.0])
    for y0 in ([1.0], [1.0, 2.0, 3.0], [1j, 2.0], [np.nan, 0.0]):
        with pytest.raises(ValueError, match="y0"):
            solver(y0)
    with pytest.raises(TypeError):
        solver(args=(1.0,))
    same(solver(), solve_ivp(lambda t, y: -y, SPAN, [1.0, 2.0]))
