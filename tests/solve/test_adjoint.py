"""Derivatives by a sweep back over the steps: `adjoint=`, and the function `vjp` of its result."""

import copy
import pickle
import threading

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.kernels.methods import METHODS
from fastdyn.solve.adjoint.keeping import Keeping
from support.discrete_solution import flat, gradient

EPS = np.finfo(float).eps
PAIRS = [name for name, method in METHODS.items() if method.is_pair]
TOLERANCES = {"rtol": 1e-8, "atol": 1e-8}


def pendulum(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


def satellite(t, y, gm):
    r = np.sqrt(y[0] ** 2 + y[1] ** 2)
    return [y[2], y[3], -gm * y[0] / r**3, -gm * y[1] / r**3]


def lotka_volterra(t, y, a, b, c, d):
    return [a * y[0] - b * y[0] * y[1], -c * y[1] + d * y[0] * y[1]]


def lorenz(t, y, s, r, b):
    return [s * (y[1] - y[0]), y[0] * (r - y[2]) - y[1], y[0] * y[1] - b * y[2]]


def chain(t, y, stiffness):
    n = len(y) // 2
    x, v = y[:n], y[n:]
    between = np.concatenate((x[:1], x[1:] - x[:-1], -x[-1:]))
    force = stiffness * (between + 0.1 * between**3)
    return np.concatenate((v, force[1:] - force[:-1]))


def network(t, y, first, bias, second):
    return second @ np.tanh(first @ y + bias)


def stick(t, y, drive, wear):
    """A drag that changes its law, a wave cut to one side, a spring that begins to act."""
    drag = wear * y[1] if abs(y[1]) < 0.5 else wear * y[1] * abs(y[1]) + 0.25 * wear * np.sign(y[1])
    push = np.where(np.sin(t) > 0, np.sqrt(np.abs(np.sin(t))), 0.0)
    return [y[1], -y[0] - drag + drive * push - max(y[0] - 1.0, 0.0)]


def complex_stick(t, y, drive, wear):
    size = y[1] if y[1].real >= 0 else -y[1]
    drag = wear * y[1] * size + 0.25 * wear * np.sign(y[1].real)
    drag = wear * y[1] if size.real < 0.5 else drag
    push = np.sqrt(np.abs(np.sin(t))) if np.sin(t) > 0 else 0.0
    return [y[1], -y[0] - drag + drive * push - (y[0] - 1.0 if y[0].real > 1 else 0.0)]


def epidemic(t, y, contact, rates, beds):
    """Beds that are full, and a contact that falls with the number of the ill."""
    s, e, i = y
    new = contact * s * i / (1 + 3 * i) ** 2
    cured = np.minimum(rates[1] * i, beds)
    return [-new, new - rates[0] * e, rates[0] * e - cured]


def dose_in_steps(t, y, table, v_max, k_m):
    """Enzyme kinetics of a dose that is read from a table, with a root and a logarithm."""
    dose = np.interp(t, [0.0, 1.0, 2.5, 4.0], table)
    return [dose - v_max * y[0] / (k_m + y[0]), np.sqrt(1 + y[0]) - y[1] * np.log1p(y[0])]


def brusselator(t, y, a, b):
    return [a + y[0] ** 2 * y[1] - (b + 1) * y[0], b * y[0] - y[0] ** 2 * y[1]]


def double_pendulum(t, y, m, g):
    p, q, u, v = y
    c, s = np.cos(p - q), np.sin(p - q)
    total = (m[0] + m[1]) * np.sin(p) * g
    rate = m[1] * (g * np.sin(q) * c - s * (u**2 * c + v**2)) - total
    other = (m[0] + m[1]) * (u**2 * s - g * np.sin(q)) + c * (total + m[1] * v**2 * s)
    below = m[0] + m[1] * s**2
    return [u, v, rate / below, other / below]


def gates(t, y, drive, slope):
    """A cell's membrane: exponentials, and a current that is cut to a range."""
    current = np.where(np.sin(3 * t) > 0.3, drive, 0.2 * drive)
    open_to = 1 / (1 + np.exp(-slope * (y[0] + 0.2)))
    pump = np.maximum(y[1] - 0.5, 0.1 * (y[1] - 0.5))
    return [y[0] - y[0] ** 3 - y[1] + current, 0.3 * (open_to - y[1]) - 0.2 * pump]


def coupled(t, y, frequencies, matrix):
    phase = y[None, :] - y[:, None]
    return frequencies + (matrix * np.sin(phase)).sum(axis=1)


def heat(t, u, diffusivity):
    flow = diffusivity * (u[1:] - u[:-1])
    return np.concatenate((flow[:1], flow[1:] - flow[:-1], -flow[-1:]))


RNG = np.random.default_rng(3)
WEIGHTS = RNG.normal(size=(12, 4)) / 2, RNG.normal(size=12) / 3, RNG.normal(size=(4, 12)) / 3
CHAIN = np.concatenate((RNG.normal(size=30), np.zeros(30))), (RNG.uniform(0.5, 2.0, 31),)
SYSTEMS = {
    "pendulum": (pendulum, (0, 10), [1.0, 0.3], (9.81, 0.2)),
    "satellite": (satellite, (0, 20), [1.0, 0.0, 0.1, 1.1], (1.0,)),
    "backwards": (satellite, (3, -2), [1.0, 0.0, 0.1, 1.1], (1.0,)),
    "Lotka-Volterra": (lotka_volterra, (0, 12), [10.0, 5.0], (1.1, 0.4, 0.4, 0.1)),
    "Lorenz": (lorenz, (0, 2), [1.0, 1.0, 20.0], (10.0, 28.0, 8 / 3)),
    "stick": (stick, (0, 10), [0.4, 1.2], (1.3, 0.6)),
    "network": (network, (0, 5), [0.3, -0.5, 1.0, 0.2], WEIGHTS),
    "chain": (chain, (0, 10), *CHAIN),
    "epidemic": (epidemic, (0, 40), [0.99, 0.0, 0.01], (1.4, np.array([0.3, 0.2]), 0.01)),
    "dose": (dose_in_steps, (0, 4), [0.3, 0.1], (np.array([0.0, 2.0, 0.5, 0.0]), 1.1, 0.4)),
    "Brusselator": (brusselator, (0, 8), [1.2, 2.0], (1.0, 2.6)),
    "double pendulum": (
        double_pendulum,
        (0, 3),
        [1.0, 0.5, 0.0, 0.1],
        (np.array([1.0, 0.6]), 9.81),
    ),
    "gates": (gates, (0, 10), [-0.5, 0.3], (0.6, 4.0)),
    "oscillators": (
        coupled,
        (0, 5),
        np.arange(6.0),
        (np.linspace(0, 1, 6), np.cos(np.arange(36.0)).reshape(6, 6)),
    ),
}
CASES = [(name, "RK45") for name in SYSTEMS] + [("pendulum", name) for name in PAIRS]


def outputs(t_span, k=17):
    """Times inside steps, and both ends."""
    return np.linspace(*t_span, k)


@pytest.mark.few(11)
@pytest.mark.parametrize(("name", "method"), CASES)
def test_the_derivatives_are_exact_for_the_discrete_solution(name, method):
    """Complex steps of the same steps in NumPy: rounding alone is left, which steps amplify."""
    fun, t_span, y0, args = SYSTEMS[name]
    t_eval, how = outputs(t_span), {"args": args, **TOLERANCES}
    r = solve_ivp(fun, t_span, y0, method, t_eval, adjoint=("y0", "args"), **how)
    plain = solve_ivp(fun, t_span, y0, method, t_eval, **how)
    assert np.array_equal(r.y, plain.y) and np.array_equal(r.t, plain.t)
    g = np.random.default_rng(0).normal(size=r.y.shape)
    found = [np.ravel(v) for v in r.vjp(g).values()]
    rng = np.random.default_rng(1)
    which = [(j, i) for j, v in enumerate(found) for i in rng.permutation(v.size)[:3]]
    steps = solve_ivp(fun, t_span, y0, method, **how).t
    fun = complex_stick if name == "stick" else fun
    exact = gradient(fun, steps, y0, args, method, t_eval, g, which)
    size = np.abs(np.concatenate(found)).max()
    mine = np.array([found[j][i] for j, i in which])
    assert np.abs(mine - exact).max() <= 4 * EPS * len(steps) * size


def test_every_step_as_output():
    fun, t_span, y0, args = SYSTEMS["Lorenz"]
    r = solve_ivp(fun, t_span, y0, args=args, **TOLERANCES, adjoint=("y0", "args"))
    g = np.random.default_rng(0).normal(size=r.y.shape)
    which = [(0, 2), (1, 0), (3, 0)]
    exact = gradient(fun, r.t, y0, args, "RK45", r.t, g, which)
    found = r.vjp(g)
    mine = [found["y0"][2], found["s"], found["b"]]
    assert np.abs(mine - exact).max() <= 4 * EPS * len(r.t) * np.abs(flat(found)).max()


@pytest.mark.parametrize("name", ["stick", "pendulum"])
def test_beside_forward_sensitivities(name):
    """Another discrete solution, of the same problem: Tsit5's steps end where the wave is cut."""
    fun, t_span, y0, args = SYSTEMS[name]
    given = (fun, t_span, y0, "Tsit5", outputs(t_span))
    a = solve_ivp(*given, args=args, rtol=1e-10, atol=1e-10, adjoint=("y0", "args"))
    b = solve_ivp(*given, args=args, rtol=1e-11, atol=1e-11, sensitivity=("y0", "args"))
    g = np.random.default_rng(0).normal(size=a.y.shape)
    exact = {k: np.einsum("i...k,ik->...", s, g) for k, s in b.sensitivity.items()}
    limit = 1e-3 if name == "stick" else 1e-6  # a step that contains a kink is less exact
    assert np.abs(flat(a.vjp(g)) - flat(exact)).max() <= limit * np.abs(flat(exact)).max()


@pytest.mark.parametrize("method", ["RK45", "Vern7"])
@pytest.mark.parametrize("t_span", [(0, 3), (3, 0)])
def test_jumps_at_known_times(method, t_span, monkeypatch):
    """A force that begins, ends and turns: the solution is a sum of parabolas and exponentials."""

    def fun(t, y, a, b):
        force = a if t < 1 else b if t < 2 else -a
        return [-y[0] + force]

    given = (fun, t_span, [0.5], method, np.array([t_span[1]], float))
    how = {"args": (2.0, 3.0), "rtol": 1e-9, "atol": 1e-9, "breakpoints": [1.0, 2.0]}
    e = np.exp(-np.arange(4.0)) if t_span[1] else np.exp(np.arange(4.0))
    first, middle, last = (1 - e[1]) * e[2], (1 - e[1]) * e[1], 1 - e[1]
    if not t_span[1]:  # the force of (2, 3) comes first
        first, last = last, first
    expected = {"y0": [e[3]], "a": first - last, "b": middle}
    whole = solve_ivp(*given, **how, adjoint=("y0", "args")).vjp([[1.0]])
    monkeypatch.setattr(Keeping, "room", 4)
    parts = solve_ivp(*given, **how, adjoint=("y0", "args")).vjp([[1.0]])
    for name, value in expected.items():
        assert np.allclose(whole[name], value, rtol=1e-7, atol=1e-7 * e.max())
        assert np.array_equal(whole[name], parts[name])


@pytest.mark.parametrize("t_eval", [None, np.linspace(0, 8, 33)])
@pytest.mark.parametrize("room", [Keeping.room, 20])
def test_events_that_do_not_act(t_eval, room, monkeypatch):
    """They change no derivative; the last one ends the run within a step."""
    monkeypatch.setattr(Keeping, "room", room)

    def crossing(t, y, k):
        return y[0]

    def falls(t, y, k):
        return y[1] + 0.7

    falls.terminal, falls.direction = 3, -1
    given = (lambda t, y, k: [y[1], -k * y[0]], (0, 20), [1.0, 0.0], "RK45", t_eval)
    r = solve_ivp(
        *given, events=[crossing, falls], args=(1.0,), **TOLERANCES, adjoint=("y0", "args")
    )
    end = r.t_events[1][2]
    assert r.status == 1 and len(r.t_events[0]) == 4 and r.t[-1] <= end < 14
    found = r.vjp(np.vstack([np.ones(len(r.t)), np.zeros(len(r.t))]))
    assert np.allclose(found["y0"], [np.cos(r.t).sum(), np.sin(r.t).sum()], atol=1e-5 * len(r.t))
    assert np.isclose(found["k"], (-r.t * np.sin(r.t) / 2).sum(), atol=1e-5 * len(r.t))


def test_shapes_and_names():
    def fun(t, y, a, table, b):
        return [-a * y[0] + table[1, 0] * y[1], -b * y[1] + table[0, 2]]

    args = (1.0, np.arange(6.0).reshape(2, 3) / 10, 2)
    r = solve_ivp(fun, (0, 1), [1.0, 0.5], args=args, adjoint=("b", "table", "y0"))
    found = r.vjp(np.ones_like(r.y))
    assert [*found] == ["b", "table", "y0"]
    assert isinstance(found["b"], float) and found["y0"].shape == (2,)
    assert found["table"].shape == (2, 3)
    assert np.array_equal(found["table"] != 0, [[False, False, True], [True, False, False]])
    assert [*solve_ivp(fun, (0, 1), [1.0, 0.5], args=args, adjoint="args[0]").vjp(r.y)] == ["a"]


@pytest.mark.parametrize("name", ["stick", "chain"])
def test_states_that_are_computed_again_have_the_same_bits(name, monkeypatch):
    fun, t_span, y0, args = SYSTEMS[name]
    given = (fun, t_span, y0, "Tsit5", outputs(t_span))
    r = solve_ivp(*given, args=args, **TOLERANCES, adjoint=("y0", "args"))
    g = np.random.default_rng(0).normal(size=r.y.shape)
    whole = r.vjp(g)
    monkeypatch.setattr(Keeping, "room", 12 * len(y0))
    monkeypatch.setattr(Keeping, "_piece", 5)
    again = solve_ivp(*given, args=args, **TOLERANCES, adjoint=("y0", "args"))
    assert np.diff(again.vjp._legs[0].rows).max() >= 8
    parts = again.vjp(g)
    assert all(np.array_equal(whole[k], parts[k]) for k in whole)
    assert np.array_equal(r.y, again.y)


def test_steps_beyond_the_limit_of_stability_are_taken_again():
    """The exact derivatives of 64 steps are 5e8 instead of -0.2: their fast modes are unstable."""
    n, t_eval = 200, np.linspace(0, 40, 10)
    x = np.linspace(0, 1, n)
    args, y0 = (1.0 + 0.5 * np.sin(7 * x[1:]),), np.exp(-40 * (x - 0.4) ** 2)

    def solved(**how):
        r = solve_ivp(heat, (0, 40), y0, "Tsit5", t_eval, args=args, adjoint=("y0", "args"), **how)
        return r, r.vjp(r.y)

    r, found = solved(rtol=1e-6, atol=1e-6)
    _, exact = solved(rtol=1e-9, atol=1e-9, max_step=0.2)
    assert np.abs(flat(found) - flat(exact)).max() < 1e-4 * np.abs(flat(exact)).max()
    steps = _first_steps(y0, args, t_eval)
    first, _ = r.vjp._swept(steps, np.ascontiguousarray(r.y.T), {})
    assert np.abs(first).max() > 1e3 * np.abs(flat(exact)).max()  # as without the guard


def _first_steps(y0, args, t_eval):
    given = (heat, (0, 40), y0, "Tsit5", t_eval)
    return solve_ivp(*given, args=args, rtol=1e-6, atol=1e-6, adjoint="y0").vjp._legs


def test_later_changes_of_outside_values_change_nothing():
    stiffness, mass = np.array([2.0, 1.0]), {"m": np.array([1.0, 3.0])}

    def fun(t, y, k):
        return [y[1], -k[0] * np.sin(y[0]) / mass["m"][1] - k[1] * y[1]]

    r = solve_ivp(fun, (0, 5), [1.0, 0.0], args=(stiffness,), adjoint=("y0", "args"))
    g = np.ones_like(r.y)
    before = r.vjp(g)
    stiffness[:] = 7.0
    mass["m"][:] = 9.0
    r.y[:] = r.t[:] = 0.0
    g2 = np.ones_like(r.y)
    after = r.vjp(g2)
    assert all(np.array_equal(before[k], after[k]) for k in before)
    other = solve_ivp(fun, (0, 5), [1.0, 0.0], args=(stiffness,), adjoint="k")
    assert not np.allclose(other.vjp(np.ones_like(other.y))["k"], before["k"])


def test_many_calls_in_many_threads_give_the_same_bits():
    fun, t_span, y0, args = SYSTEMS["chain"]
    r = solve_ivp(fun, t_span, y0, t_eval=outputs(t_span), args=args, adjoint=("y0", "args"))
    g = np.random.default_rng(0).normal(size=(20, *r.y.shape))
    first, found = [flat(r.vjp(each)) for each in g], [None] * len(g)

    def run(i):
        found[i] = flat(r.vjp(g[i]))

    threads = [threading.Thread(target=run, args=(i,)) for i in range(len(g))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(first, found, strict=True))
    both = flat(r.vjp(g[0] + g[1]))
    assert np.allclose(both, first[0] + first[1], rtol=1e-12, atol=1e-12 * np.abs(both).max())


@pytest.mark.parametrize("k", [3, 400])
def test_repeated_calls_give_the_same_bits(k):
    """A list in place of the tuple of arguments takes the way of a first call."""
    fun, t_span, y0, args = SYSTEMS["chain"]
    results = []
    for i in range(10):
        stiffness, state, t_eval = args[0] * (1 + i / 20), y0 + i / 10, outputs(t_span, k) / (1 + i)
        given = (fun, t_span, state, "Tsit5", t_eval)
        r = solve_ivp(*given, args=(stiffness,), adjoint=("y0", "args"))
        g = np.cos(r.y)
        again = solve_ivp(*given, args=[stiffness.copy()], adjoint=("y0", "args"))
        found, expected = r.vjp(g), again.vjp(g)
        assert all(np.array_equal(found[name], expected[name]) for name in expected)
        results.append((r, g, found))
        stiffness[:] = np.nan
    for r, g, found in results:
        assert all(np.array_equal(found[name], v) for name, v in r.vjp(g).items())
    other = solve_ivp(fun, t_span, y0, "Tsit5", outputs(t_span, k), args=args, adjoint="args")
    assert [*other.vjp(np.ones_like(other.y))] == ["stiffness"]
    with pytest.raises(ValueError):
        solve_ivp(fun, t_span, y0, "Tsit5", outputs(t_span, k), args=(np.ones(7),), adjoint="args")


def test_repeated_calls_in_threads_and_a_function_that_changes():
    scale, found = [1.0], {}

    def fun(t, y, a):
        return [y[1], -a * scale[0] * np.sin(y[0])]

    def one(i):
        r = solve_ivp(fun, (0, 3), [1.0, 0.1 * i], t_eval=[1.0, 3.0], args=(1.0 + i,), adjoint="a")
        found[i] = r.vjp(np.ones((2, 2)))["a"]

    for i in range(12):
        one(i)
    alone = dict(found)
    threads = [threading.Thread(target=one, args=(i,)) for i in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert alone == found
    scale[0] = 2.0
    one(3)
    other = solve_ivp(
        lambda t, y, a: [y[1], -a * 2.0 * np.sin(y[0])], (0, 3), [1.0, 0.1 * 3], t_eval=[1.0, 3.0],
        args=(4.0,), adjoint="a",
    )  # fmt: skip
    assert np.isclose(found[3], other.vjp(np.ones((2, 2)))["a"], rtol=1e-12)
    scale[0] = "two"
    with pytest.raises(TypeError, match="sequence"):
        one(3)


def test_auto_takes_a_pair():
    fun, t_span, y0, args = SYSTEMS["pendulum"]
    for rtol, name in ((1e-4, "Tsit5"), (1e-7, "Vern7"), (1e-10, "Vern9")):
        r = solve_ivp(fun, t_span, y0, "auto", args=args, rtol=rtol, adjoint="args")
        assert r.method == name and r.vjp(r.y)["damping"] < 0


def test_a_result_is_copied_and_not_pickled():
    fun, t_span, y0, args = SYSTEMS["pendulum"]
    r = solve_ivp(fun, t_span, y0, args=args, adjoint="args")
    assert "vjp of" in repr(r)
    assert flat(copy.deepcopy(r).vjp(r.y)).tolist() == flat(r.vjp(r.y)).tolist()
    with pytest.raises(TypeError, match="`vjp` lives in this process"):
        pickle.dumps(r)
    del r["vjp"]
    pickle.dumps(r)


@pytest.mark.parametrize("option", ["sensitivity", "adjoint"])
def test_an_error_of_the_function_is_its_own(option):
    def fun(t, y, k):
        return [-k * y[0] / undefined]  # noqa: F821  # pyright: ignore[reportUndefinedVariable]

    with pytest.raises(NameError, match="undefined"):
        solve_ivp(fun, (0.0, 1.0), [1.0], "Tsit5", args=(1.0,), **{option: "args"})
