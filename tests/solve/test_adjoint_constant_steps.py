"""Derivatives by a sweep back over constant steps: RK4, and kicks and drifts."""

import itertools

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.methods import BY_NAME, METHODS
from fastdyn.kernels.methods.within_steps import basis, nodes_of, of_data
from fastdyn.solve.adjoint.keeping import Keeping
from support.discrete_solution import by_complex_steps, flat, gradient
from support.impacts import flight, marked

KICKS = [name for name, method in METHODS.items() if method.backward == "kicks"]
EPS, H = np.finfo(float).eps, 0.07
ORBIT = [0.1, 0.2, 0.3, 0.0], (1.0, 0.7, 1.1)


def henon_heiles(t, y, a, b, c):
    q, p, u, w = y
    return [u, w, -q - 2 * a * q * p + 0.1 * np.sin(t), -b * p - a * q * q + c * p * p]


def shifted(y, rate, t, h, args, table):
    """The state and its slope behind one step of kicks and drifts."""
    m, at = len(y) // 2, t
    q, v = y[:m], y[m:]
    for kick, drift in itertools.zip_longest(table["kicks"], table["drifts"], fillvalue=0.0):
        v = v + kick * h * rate
        q, at = q + drift * h * v, at + drift * h
        rate = np.array(henon_heiles(at, [*q, *v], *args)[m:])
    return np.concatenate([q, v]), np.concatenate([v, rate])


def kicked(y, steps, args, name, t_eval):
    """The outputs of steps from each time to the next, real or complex."""
    table, m = BY_NAME[name].tableau, (BY_NAME[name].n_dense - 3) // 2
    found, rows = [], of_data(m)
    slope = np.array(henon_heiles(steps[0], y, *args))
    for t, end in itertools.pairwise(steps):
        rate = slope[len(y) // 2 :]
        new, final = shifted(y, rate, t, H, args, table)
        inside = t_eval[(t_eval > t) & (t_eval <= end)]
        if len(inside):
            data = [y, H * slope, new, H * final]
            for x in nodes_of(m):
                between, rise = shifted(y, rate, t, x * H, args, table)
                data += [between, H * rise]
        for time in inside:
            factors = [1.0, *[factor((time - t) / H) for factor in basis(m)]]
            found.append(factors @ rows @ np.array(data))
        y, slope = new, final
    return np.array(found).T


@pytest.mark.few(2)
@pytest.mark.parametrize("name", KICKS)
def test_kicks_and_drifts(name):
    """Complex steps of the same steps in NumPy; the last step passes the end of the span."""
    t_eval, steps = np.array([0.3, 0.35, 1.9, 3.0]), H * np.arange(44)
    given = (henon_heiles, (0, 3), ORBIT[0], name, t_eval)
    r = solve_ivp(*given, args=ORBIT[1], step=H, adjoint=("y0", "args"))
    g = np.random.default_rng(0).normal(size=r.y.shape)

    def number(*values):
        y = kicked(np.array(values[:4]), steps, values[4:], name, t_eval)
        return (g * y).sum()

    assert np.isclose(number(*ORBIT[0], *ORBIT[1]), (g * r.y).sum(), rtol=1e-12)
    exact = by_complex_steps(number, *ORBIT)
    assert np.abs(flat(r.vjp(g)) - exact).max() <= 4 * EPS * len(steps) * np.abs(exact).max()


@pytest.mark.few
@pytest.mark.parametrize("name", ["VelocityVerlet", "BlanesMoan6", "RK4"])
@pytest.mark.parametrize(("span", "t_eval"), [((0, 3), None), ((1, -2), [0.7, 0.2, -2])])
@pytest.mark.parametrize("room", [Keeping.room, 30])
def test_as_forward(name, span, t_eval, room, monkeypatch):
    """The tangent map of kicks and drifts; RK4's sensitivities are those of its steps, too."""
    monkeypatch.setattr(Keeping, "room", room)
    monkeypatch.setattr("fastdyn.solve.adjoint.solve.ROOM", room)
    given = (henon_heiles, span, ORBIT[0], name, t_eval)
    how = {"args": ORBIT[1], "step": H}
    r = solve_ivp(*given, **how, adjoint=("y0", "args"))
    assert r.vjp._legs[0].is_whole == (room > 30)
    g = np.random.default_rng(0).normal(size=r.y.shape)
    s = solve_ivp(*given, **how, sensitivity=("y0", "args")).sensitivity
    exact = flat({name: np.einsum("i...k,ik->...", each, g) for name, each in s.items()})
    assert np.abs(flat(r.vjp(g)) - exact).max() <= 200 * EPS * np.abs(exact).max()


def test_rk4():
    """Also in repeated calls, whose steps are ready."""
    t_eval = np.array([0.3, 0.35, 1.9, 3.0])
    for k in range(8):
        y0 = np.array(ORBIT[0]) + k / 50
        r = solve_ivp(
            henon_heiles, (0, 3), y0, "RK4", t_eval, args=ORBIT[1], step=H, adjoint=("y0", "args")
        )
        g = np.random.default_rng(0).normal(size=r.y.shape)
        which, steps = [(0, 1), (1, 0), (3, 0)], H * np.arange(44)
        exact = gradient(henon_heiles, steps, y0, ORBIT[1], "RK4", t_eval, g, which)
        found = flat(r.vjp(g))
        assert np.abs(found[[1, 4, 6]] - exact).max() <= 4 * EPS * 44 * np.abs(found).max()


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["VelocityVerlet", "RK4", "Gauss4", "GaussNystrom8"])
@pytest.mark.parametrize("t_eval", [np.linspace(0.1, 2.2, 12), None])
def test_events_and_schedules(name, t_eval):
    """A ball that bounces: the steps are exact, and begin anew at a schedule."""
    ground = marked(lambda t, y, g, e: y[0], direction=-1)
    y0, args = [1.3, 0.4], (9.81, 0.8)
    r = solve_ivp(
        lambda t, y, g, e: [y[1], -g], (0, 2.3), y0, name, t_eval, args=args, step=H,
        events=[ground, fastdyn.at([0.5, 1.0])], adjoint=("y0", "args"),
        on_event=[lambda t, y, g, e: [0.0 * y[0], -e * y[1]], None],
    )  # fmt: skip
    assert [len(t) for t in r.t_events] == [3, 2]
    times = r.t if t_eval is not None else r.t[-1:]
    g, c = np.zeros(r.y.shape), np.array([0.3, -1.0, 2.0])
    g[:, -len(times) :] = np.random.default_rng(0).normal(size=(2, len(times)))
    at_schedule = np.array([[0.0, 0.0], [1.0, -2.0]])

    def number(*values):
        y, impacts = flight(times, *values)
        there, _ = flight([1.0], *values)
        return (g[:, -len(times) :] * y).sum() + c @ impacts + at_schedule[1] @ there[:, 0]

    found = flat(r.vjp(g, t_events=[c, None], y_events=[None, at_schedule]))
    assert np.allclose(found, by_complex_steps(number, y0, args), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("name", "step"), [("VelocityVerlet", 1.01), ("RK4", 1.46)])
def test_steps_beyond_the_limit_of_stability_are_shortened(name, step):
    """A ring of masses whose fastest modes, of frequency 2, are at rest."""
    n, t_end = 20, 90.0

    def ring(t, y, k):
        pull = k * (np.roll(y[:n], -1) - y[:n])
        return np.concatenate((y[n:], pull - np.roll(pull, 1)))

    x = 1.5 + np.cos(2 * np.pi * np.arange(n) / n)

    def solved(method, **options):
        r = solve_ivp(
            ring, (0, t_end), [*x, *(0.3 * x - 0.45)], method, [t_end], args=(np.ones(n),),
            adjoint="k", **options,
        )  # fmt: skip
        before = len(r.vjp._legs[0].t)
        return r, r.vjp(np.eye(2 * n)[:, :1])["k"], before, len(r.vjp._legs[0].t)

    r, found, before, after = solved(name, step=step)
    expected = solved("Vern9", rtol=1e-9, atol=1e-9)[1]
    assert np.abs(r.y).max() < 3 and after > before
    assert np.abs(found - expected).max() < 0.5 * np.abs(expected).max()


@pytest.mark.filterwarnings("ignore::fastdyn.SwitchingWarning")
@pytest.mark.parametrize("t_eval", [None, np.array([0.5, 1.0])])
def test_constant_steps_pass_the_switches_of_an_input(t_eval):
    """They end nowhere else for a sweep, the second time as the first, and keep their length."""
    u = np.random.default_rng(2).normal(size=20)

    def fun(t, y, u):
        return [u[min(int(t * 20), 19)] - y[0], y[0] - 0.5 * y[1]]

    def solved(u, **how):
        return solve_ivp(fun, (0, 1), [1.0, 0.5], "RK4", t_eval, args=(u,), step=0.08, **how)

    plain = solved(u).y
    for _ in range(3):
        r = solved(u, adjoint="u")
        assert np.array_equal(r.y, plain)
        g = np.cos(np.arange(r.y.size)).reshape(r.y.shape)
        rows = [np.sum(g * (solved(u + e).y - solved(u - e).y)) / 2 for e in np.eye(20)]
        assert np.abs(r.vjp(g)["u"] - rows).max() < 1e3 * EPS  # some 30 sums of 13 steps
