"""Claims about hybrid systems: discrete states, by motions with exact or published answers."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from fastdyn import METHODS, solve_ivp
from tests.support.impacts import marked
from tests.support.thermostat import SWITCH, heated

TIGHT = {"rtol": 1e-10, "atol": 1e-12}
SOLVED = [name for name, m in METHODS.items() if not m.second_order]


def test_a_thermostat_switches_when_exponentials_say():
    run = solve_ivp(
        heated, (0.0, 30.0), [19.5], args=(4.0,), discrete=[0.0], dense_output=True,
        **SWITCH, **TIGHT,
    )  # fmt: skip
    warm = 10.0 + 4.0 / 0.2
    cooling, heating = 5.0 * math.log(11.0 / 9.0), 5.0 * math.log((warm - 19.0) / (warm - 21.0))
    first = 5.0 * math.log(9.5 / 9.0)
    on = first + np.arange(20) * (cooling + heating)
    on = on[on < 30.0]
    assert np.allclose(run.t_events[0], on, atol=1e-8)
    assert np.allclose(run.t_events[1], on[: len(run.t_events[1])] + heating, atol=1e-8)
    assert run.y.shape == (1, len(run.t)) and run.discrete.shape == (1, len(run.t))
    assert set(np.unique(run.discrete)) == {0.0, 1.0}
    twice = np.flatnonzero(np.diff(run.t) == 0.0)
    assert np.array_equal(run.discrete[0, twice], 1.0 - run.discrete[0, twice + 1])
    assert (run.discrete_events[0] == 0.0).all() and (run.discrete_events[1] == 1.0).all()
    assert run.y_events[0].shape == (len(on), 1) and run.sol(3.0).shape == (1,)


LIMIT, PERIOD, GAINS = 1.5, 0.01, (6.0, 4.0, 0.5)


def plant(t, y, d, target):
    return [y[1], -y[0] - 0.4 * y[1] + d[0]]


def pid(t, y, d, target):
    """A PID at 100 Hz with saturation; the integral waits while the output is at its limit."""
    _, total, last = d
    error = target - y[0]
    grown = total + PERIOD * error
    wanted = GAINS[0] * error + GAINS[1] * grown + GAINS[2] * (error - last) / PERIOD
    held = min(max(wanted, -LIMIT), LIMIT)
    return y, [held, grown if held == wanted else total, error]


def sampled(n, target):
    """The states and the memories before each of n samples, by matrix exponentials."""
    a = np.array([[0.0, 1.0, 0.0], [-1.0, -0.4, 1.0], [0.0, 0.0, 0.0]])
    step, y, d, found = expm(PERIOD * a), np.zeros(2), [0.0, 0.0, 0.0], []
    for _ in range(n):
        found.append([*y, *d])
        y, d = pid(0.0, y, d, target)
        y = (step @ [*y, d[0]])[:2]
    return np.array(found)


@pytest.mark.parametrize("method", ["RK45", "Vern7", "Radau", "Rodas5P", "BDF", "LSODA", "RK4"])
def test_a_sampled_pid_with_anti_windup_is_that_of_matrix_exponentials(method):
    options = {"step": 0.01} if method == "RK4" else {"rtol": 1e-9, "atol": 1e-11}
    run = solve_ivp(
        plant, (0.0, 8.0), [0.0, 0.0], method, args=(1.0,), every=PERIOD, on_event=pid,
        discrete=[0.0, 0.0, 0.0], **options,
    )  # fmt: skip
    n = len(run.t_events[0])
    exact = sampled(n, 1.0)
    assert n == 800 and (exact[:, 2] == LIMIT).sum() > 20  # it saturates
    states = np.hstack([run.y_events[0], run.discrete_events[0]])
    bound = {"BDF": 1e-5, "LSODA": 1e-5, "RK4": 1e-8}.get(method, 1e-7)
    assert np.abs(states - exact).max() <= bound


MU = (1.0, 0.6)
BELT = 0.3


def dragged(t, y, d):
    """A block on a belt: it sticks (d = 1), or slips against a spring."""
    return [y[1], (1.0 - d[0]) * (MU[1] - y[0])]


def test_a_stick_slip_oscillator_has_its_exact_period():
    breaks = marked(lambda t, y, d: d[0] * (y[0] - MU[0]), direction=1)
    sticks = marked(lambda t, y, d: (1.0 - d[0]) * (y[1] - BELT), direction=1)
    run = solve_ivp(
        dragged, (0.0, 60.0), [0.0, BELT], "DOP853", events=[breaks, sticks], discrete=[1.0],
        on_event=[lambda t, y, d: (y, [0.0]), lambda t, y, d: ([y[0], BELT], [1.0])], **TIGHT,
    )  # fmt: skip
    gap = MU[0] - MU[1]
    period = 2.0 * gap / BELT + 2.0 * (math.pi - math.atan(gap / BELT))
    assert len(run.t_events[0]) >= 7 and np.allclose(np.diff(run.t_events[0]), period, atol=1e-8)
    assert np.allclose(run.y_events[1][:, 0], MU[1] - gap, atol=1e-8)


@pytest.mark.parametrize("method", [m for m in SOLVED if METHODS[m].error_order])
def test_discrete_states_do_not_count_in_the_error(method):
    def swinging(t, y):
        return [y[1], -2.0 * y[0] - 0.3 * y[1] ** 3 + 0.7]

    def held(t, y, d):
        return [y[1], -2.0 * y[0] - 0.3 * y[1] ** 3 + d[0]]

    plain = solve_ivp(swinging, (0.0, 10.0), [1.0, 0.0], method, rtol=1e-6, atol=1e-9)
    run = solve_ivp(
        held, (0.0, 10.0), [1.0, 0.0], method, rtol=1e-6, atol=1e-9, discrete=[0.7, 1e9],
        at=[10.0], on_event=lambda t, y, d: (y, d),
    )  # fmt: skip
    assert run.n_accepted == plain.n_accepted and np.allclose(
        run.y[:, -1], plain.y[:, -1], atol=1e-8
    )


def test_memories_of_python_functions_are_kept():
    memory = {"n": 0}

    def counted(t, y, d):
        memory["n"] += 1
        return y, [float(memory["n"])]

    with pytest.warns(UserWarning):
        run = solve_ivp(
            lambda t, y, d: [-y[0] + d[0]], (0.0, 2.5), [1.0], every=1.0, on_event=counted,
            discrete=[0.0],
        )  # fmt: skip
    assert np.array_equal(np.diff(run.discrete_events[0][:, 0]), [1.0, 1.0])


def test_checkpoints_carry_discrete_states(tmp_path):
    given = {"args": (1.0,), "every": PERIOD, "on_event": pid, "discrete": [0.0, 0.0, 0.0], **TIGHT}
    whole = solve_ivp(plant, (0.0, 1.0), [0.0, 0.0], **given)
    file = tmp_path / "run"
    part = solve_ivp(plant, (0.0, 1.0), [0.0, 0.0], checkpoint=file, max_steps=57, **given)
    rest = solve_ivp(plant, (0.0, 1.0), [0.0, 0.0], checkpoint=file, **given)
    assert part.status == -1 and np.array_equal(rest.discrete, whole.discrete)
    assert np.array_equal(rest.y, whole.y)


def test_an_event_rests_for_a_time_after_it_acted():
    """A sensor counts the passages of a pendulum, and rests for 1.9 seconds after each."""

    def passed(t, y, d):
        return y[0]

    def counted(t, y, d):
        return y, [d[0] + 1.0, t] if t - d[1] >= 1.9 else d

    run = solve_ivp(
        lambda t, y, d: [y[1], -math.pi**2 * y[0]], (0.0, 9.9), [1.0, 0.0], events=passed,
        on_event=counted, discrete=[0.0, -2.0], **TIGHT,
    )  # fmt: skip
    assert np.allclose(run.t_events[0], np.arange(10)[: len(run.t_events[0])] + 0.5)
    assert run.discrete[:, -1] == pytest.approx([5.0, 8.5])


SENTENCES = [
    ({"discrete": ["a"]}, TypeError, "`discrete` must be numbers"),
    ({"discrete": [[1.0]]}, ValueError, "`discrete` must be 1-dimensional"),
    ({"discrete": [math.nan]}, ValueError, "finite"),
    ({"discrete": [1j]}, ValueError, "real numbers"),
    ({"discrete": []}, ValueError, "one number at least"),
    ({"on_event": None}, ValueError, "`discrete` never changes"),
    ({"every": None}, ValueError, "there are 0 events"),
    ({"on_event": lambda t, y, d: y}, ValueError, r"must return \(y, d\), 2 and 1 numbers"),
    ({"on_event": lambda t, y, d: (y, [1.0, 2.0])}, ValueError, "of 2 and 2"),
    ({"fun": lambda t, y, d: [1.0]}, ValueError, "1 value for a state of 2"),
    ({"method": "VelocityVerlet", "step": 0.1}, ValueError, "takes no `discrete`"),
    ({"vectorized": True}, ValueError, "vectorized"),
    ({"method": "LSODA", "lband": 1}, ValueError, "lband"),
    ({"nonnegative": [2]}, ValueError, "from 0 to 1"),
]


@pytest.mark.parametrize(("given", "error", "words"), SENTENCES)
def test_hostile_discrete_states_are_answered_by_sentences(given, error, words):
    usual = {
        "fun": lambda t, y, d: [y[1], -y[0] + d[0]], "t_span": (0.0, 1.0), "y0": [1.0, 0.0],
        "every": 0.1, "discrete": [0.0], "on_event": lambda t, y, d: (y, d),
    }  # fmt: skip
    with pytest.raises(error, match=words):
        solve_ivp(**{**usual, **given})


STIFF = ["Radau", "BDF", "Rodas5P", "LSODA"]


def drained(t, y, d):
    return [-d[0] * math.sqrt(y[0])]


def drained_in_python(t, y, d):
    float(repr(float(t)))  # no code is compiled from this
    return drained(t, y, d)


@pytest.mark.few(5)
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("fun", [drained, drained_in_python])
@pytest.mark.parametrize("method", ["RK45", *STIFF])
def test_only_the_state_is_kept_inside(method, fun):
    """A pump that turns round: the discrete state is negative, the level is not."""
    given = {"discrete": [1.0], "at": [0.2], "rtol": 1e-9, "atol": 1e-11}
    turned = {"on_event": lambda t, y, d: (y, [-0.5]), **given}
    for listed in (True, [0], [True]):
        run = solve_ivp(fun, (0.0, 5.0), [1.0], method, nonnegative=listed, **turned)
        assert run.discrete[0, -1] == -0.5
        assert run.y[0, -1] == pytest.approx((0.9 + 0.25 * 4.8) ** 2, abs=1e-7)
    run = solve_ivp(
        fun, (0.0, 5.0), [1.0], method, nonnegative=True, dense_output=True,
        on_event=lambda t, y, d: (y, d), **given,
    )  # fmt: skip
    assert run.success and run.sol(np.linspace(0.0, 5.0, 2001)).min() >= 0.0
    run = solve_ivp(
        fun, (0.0, 5.0), [1.0], method, domain=lambda t, y, d: y[0] - 0.3 * d[0],
        on_event=lambda t, y, d: (y, [0.5]), **given,
    )  # fmt: skip
    assert run.status == -3 and run.y[0, -1] == pytest.approx(0.15, abs=1e-7)
    assert run.t[-1] == pytest.approx(0.2 + 4.0 * (0.9 - math.sqrt(0.15)), abs=1e-7)


@pytest.mark.parametrize("method", ["Radau", "BDF", "Rodas5P"])
def test_a_mass_of_functions_gets_discrete_states(method):
    """(1 + d) y' = -y, and d = 1 from t = 1 on."""
    run = solve_ivp(
        lambda t, y, d: [-y[0]], (0.0, 2.0), [1.0], method, at=[1.0], discrete=[0.0],
        mass=lambda t, y, d: [[1.0 + d[0]]], on_event=lambda t, y, d: (y, [1.0]),
        rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    assert run.y[0, -1] == pytest.approx(math.exp(-1.5), abs=1e-6)
