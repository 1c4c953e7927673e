"""Actions on M y' = f(t, y): what M sees is held, algebraic components are solved for again."""

import math

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp
from support.masses import MASS, TAKE, decaying, half, refill, root

TIGHT = {"rtol": 1e-9, "atol": 1e-12}


@pytest.mark.few(1)
@pytest.mark.parametrize("method", TAKE)
def test_an_action_holds_x_and_solves_for_z(method):
    run = solve_ivp(
        decaying, (0, 5), [1.0, root(1.0)], method, mass=MASS, events=half, on_event=refill,
        dense_output=True, **TIGHT,
    )  # fmt: skip
    times = math.log(2.0) + math.log(4.0) * np.arange(4)
    assert np.allclose(run.t_events[0], times[times < 5.0], atol=1e-6)
    before = np.flatnonzero(np.diff(run.t) == 0.0)
    assert len(before) == 4 and np.array_equal(run.y[0, before + 1], 4.0 * run.y[0, before])
    x, z = run.y
    assert np.abs(z + z**3 - x).max() < 1e-8 and np.abs((z + z**3 - x)[before + 1]).max() < 1e-15
    assert run.y[0, -1] == pytest.approx(2.0 * math.exp(-(5.0 - times[3])), rel=3e-6)
    within = run.sol(np.linspace(0.0, 5.0, 200))
    assert np.abs(within[1] + within[1] ** 3 - within[0]).max() < 1e-6


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_actions_in_python_give_the_same():
    given = (0, 5), [1.0, root(1.0)], "Rodas5P"
    calls = []

    def refill_in_python(t, y):
        calls.append(t)
        return refill(t, y)

    runs = [
        solve_ivp(decaying, *given, mass=MASS, events=half, on_event=act, **TIGHT)
        for act in (refill, refill_in_python)
    ]
    assert len(calls) >= 4 and np.array_equal(runs[0].y, runs[1].y)

    def with_a_print(t, y):
        calls.append(t)
        return decaying(t, y)

    alone = solve_ivp(with_a_print, *given, mass=MASS, events=half, on_event=refill, **TIGHT)
    assert np.allclose(alone.y[:, -1], runs[0].y[:, -1], rtol=1e-8)


@pytest.mark.parametrize("method", TAKE)
@pytest.mark.parametrize("rows", [[0, 1], [1, 0], [0, 1]])
def test_a_ball_bounces_with_its_equations_in_any_order(method, rows):
    """Behind a bounce the sign of the height is that of y', which is not f."""
    order, scale = np.eye(2)[rows], np.array([[1.0], [-1.0]])
    mass = scale * order

    def falling(t, y):
        f = [y[1], -9.81]
        return [f[rows[0]], -1.0 * f[rows[1]]]

    def ground(t, y):
        return y[0]

    run = solve_ivp(
        falling, (0, 2), [1.0, 0.0], method, mass=mass, events=ground,
        on_event=lambda t, y: [0.0, -0.8 * y[1]], **TIGHT,
    )  # fmt: skip
    first = math.sqrt(2.0 / 9.81)
    hits = first + 2.0 * first * np.cumsum([0.0, 0.8, 0.64, 0.512, 0.4096])
    assert run.t_events[0] == pytest.approx(hits[hits < 2.0], abs=1e-6)


@pytest.mark.parametrize("method", TAKE)
def test_an_algebraic_component_that_passes_zero_as_it_begins(method):
    """The event is of z, which is 0 behind the action, and rises only because x does."""

    def rising(t, y):
        return [1.0, y[1] + 1.0 - y[0]]  # z = x - 1

    def zero(t, y):
        return y[1]

    run = solve_ivp(
        rising, (0, 3.5), [0.5, -0.5], method, mass=MASS, events=[zero, lambda t, y: y[1] - 1.0],
        on_event=[None, lambda t, y: [1.0, 5.0]], **TIGHT,
    )  # fmt: skip
    assert run.t_events[0] == pytest.approx([0.5], abs=1e-6)
    assert run.t_events[1] == pytest.approx([1.5, 2.5, 3.5][: len(run.t_events[1])], abs=1e-6)
    assert len(run.t_events[1]) >= 2


def test_as_solve_dae():
    """A diode feeds a capacitor, which a switch discharges at a voltage."""

    def circuit(t, y):
        v, node = y
        through = 0.1 * (np.exp((node - v) / 0.3) - 1.0)
        return [through - 0.05 * v, (np.sin(3.0 * t) + 1.0 - node) - through]

    def residual(t, y, yp):
        f = circuit(t, y)
        return [yp[0] - f[0], f[1]]

    def full(t, y):
        return y[0] - 0.4

    def discharge(t, y):
        return [0.1, y[1]]

    options = {"events": full, "on_event": discharge, **TIGHT}
    start = solve_dae(residual, (0, 0.1), [0.2, 1.0], given="differential").y[:, 0]
    dae = solve_dae(residual, (0, 6), start, given="differential", **options)
    for method in TAKE:
        run = solve_ivp(circuit, (0, 6), start, method, mass=MASS, **options)
        assert run.t_events[0] == pytest.approx(dae.t_events[0], abs=3e-6)
        assert len(run.t_events[0]) > 2
        assert run.y[:, -1] == pytest.approx(dae.y[:, -1], abs=3e-6)


@pytest.mark.parametrize("method", TAKE)
def test_a_sampled_controller_of_a_circuit(method):
    """Discrete states among algebraic equations; with z = x + d, x' = -x - d decays between."""

    def plant(t, y, d):
        x, z = y
        return [-z, z - x - d[0]]

    def sample(t, y, d):
        return y, [-0.5 * y[1]]

    run = solve_ivp(
        plant, (0, 1), [1.0, 1.0], method, mass=MASS, every=0.1, on_event=sample, discrete=[0.0],
        **TIGHT,
    )  # fmt: skip
    x, d, share = 1.0, 0.0, math.exp(-0.1)
    for _ in range(10):
        d = -0.5 * (x + d)
        x = -d + (x + d) * share
    assert run.y[:, -1] == pytest.approx([x, x + d], abs=3e-7)
    assert run.discrete[0, -1] == pytest.approx(d, abs=1e-8)


@pytest.mark.parametrize("method", TAKE)
def test_algebraic_equations_in_combinations(method):
    """C (v0' - v1') twice: the difference of both equations is algebraic, v0 + v1 is free of M."""
    mass = np.array([[-2.0, 2.0], [2.0, -2.0]])

    def fun(t, y):
        u, w = y[0] - y[1], y[0] + y[1]
        return [u + w - 3.0, -u + w - 3.0]  # u' = -u / 2, w = 3

    def act(t, y):
        return [2.0 * y[0] + 5.0, 2.0 * y[1] + 5.0]  # u is doubled

    run = solve_ivp(fun, (0, 2), [2.0, 1.0], method, mass=mass, at=[1.0], on_event=act, **TIGHT)
    u, w = run.y[0] - run.y[1], run.y[0] + run.y[1]
    after = np.flatnonzero(np.diff(run.t) == 0.0)[0] + 1
    assert w == pytest.approx(3.0, abs=1e-9) and w[after] == pytest.approx(3.0, abs=1e-14)
    assert u[after] == pytest.approx(2.0 * math.exp(-0.5), abs=1e-6)
    assert u[-1] == pytest.approx(2.0 * math.exp(-1.0), abs=1e-6)


@pytest.mark.parametrize("method", TAKE)
def test_algebraic_components_jump_at_breakpoints(method):
    def switched(t, y):
        return [-y[1], y[1] - (y[0] if t < 1.0 else 3.0 * y[0])]

    run = solve_ivp(switched, (0, 2), [1.0, 1.0], method, mass=MASS, breakpoints=[1.0], **TIGHT)
    assert run.y[:, -1] == pytest.approx([math.exp(-4.0), 3.0 * math.exp(-4.0)], rel=1e-5)
    assert run.success and run.n_rejected < 30


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_in_both_directions_and_at_the_start(direction):
    def fun(t, y):
        return [-direction * y[0], y[1] - y[0] * t]

    run = solve_ivp(
        fun, (0, 2.0 * direction), [1.0, 0.0], "Rodas5P", mass=MASS, at=sorted([0.0, direction]),
        on_event=lambda t, y: [y[0] + 1.0, y[1]], t_eval=[2.0 * direction], **TIGHT,
    )  # fmt: skip
    x = (2.0 * math.exp(-1.0) + 1.0) * math.exp(-1.0)
    assert run.y[:, -1] == pytest.approx([x, 2.0 * direction * x], rel=1e-7)


def no_root(t, y):
    return [-y[0], y[1] ** 2 - (2.0 - y[0])]


def no_index(t, y):
    return [-y[0], (y[1] - y[0]) * (5.0 - y[0])]


@pytest.mark.parametrize("fun, said", [(no_root, "equation 1 of `fun` stays"), (no_index, "")])
def test_an_action_without_a_consistent_state_ends_with_a_sentence(fun, said):
    def act(t, y):
        return [5.0, y[1]]

    with pytest.raises(ValueError, match=r"At t = 0\.6931.* with M y held, " + said):
        solve_ivp(fun, (0, 3), [1.0, 1.0], "Rodas5P", mass=MASS, events=half, on_event=act, **TIGHT)


def test_what_actions_raise_and_what_is_not_finite():
    given = (0, 3), [1.0, root(1.0)], "Rodas5P"

    def raises(t, y):
        raise KeyError("the user's")

    with pytest.raises(KeyError, match="the user's"):
        solve_ivp(decaying, *given, mass=MASS, events=half, on_event=raises)
    run = solve_ivp(
        decaying, *given, mass=MASS, events=half, on_event=lambda t, y: [y[0] * math.inf, y[1]]
    )
    assert run.status == -1 and "returned nan or inf" in run.message

    def fails(t, y):
        if y[0] > 2.0:
            raise ZeroDivisionError("above 2")
        return decaying(t, y)

    with pytest.raises(ZeroDivisionError, match="above 2"):
        solve_ivp(
            fails, *given, mass=MASS, events=half, on_event=lambda t, y: [5.0 * y[0] / 1.0, y[1]]
        )
