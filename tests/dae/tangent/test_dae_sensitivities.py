"""`sensitivity=` of solve_dae: derivatives of known solutions, by formulas and complex steps."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp as scipys

from fastdyn import solve_dae

TIMES = np.linspace(0, 5, 11)
H = 1e-30  # of complex steps
TIGHT = {"rtol": 1e-9, "atol": 1e-11}


def by_complex_step(f, values, j):
    values = [value + 1j * H * (k == j) for k, value in enumerate(values)]
    return f(*values).imag / H


def divider(t, y, yp, R, C):
    """A source, a resistor and a capacitor: the voltage at the capacitor, and the current."""
    u, i = y
    return [C * yp[0] - i, math.sin(t) - R * i - u]


def divider_solution(R, C, start, t=TIMES):
    T = R * C
    u = (start + T / (1 + T * T)) * np.exp(-t / T) + (np.sin(t) - T * np.cos(t)) / (1 + T * T)
    return np.array([u, (np.sin(t) - u) / R])


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_errors_follow_the_tolerance(rtol):
    values = 2.0, 0.5, 0.2
    run = solve_dae(
        divider, (0, 5), [0.2, 7.0], args=values[:2], given="differential", rtol=rtol, atol=rtol,
        t_eval=TIMES, sensitivity=("R", "C", "y0"), dense_output=True,
    )  # fmt: skip
    found = run.sensitivity["R"], run.sensitivity["C"], run.sensitivity["y0"][:, 0]
    for j, each in enumerate(found):  # dy/dC is 8 times as large as y
        assert np.abs(each - by_complex_step(divider_solution, values, j)).max() <= 20 * rtol
    assert not run.sensitivity["y0"][:, 1].any()  # the current is a guess
    assert np.abs(run.y - divider_solution(*values)).max() <= 5 * rtol
    assert run.yp.shape == run.y.shape == run.sol(TIMES).shape == (2, 11)
    assert np.array_equal(run.sol(TIMES), run.y)


def test_the_current_that_follows_at_the_start():
    """At t = 0, i = (sin 0 - u) / R: di/dR = u / R^2 and di/du = -1 / R, exactly."""
    run = solve_dae(divider, (0, 1), [0.2, 0.0], args=(2.0, 0.5), sensitivity=("R", "y0"))
    assert abs(run.sensitivity["R"][1, 0] - 0.05) <= 1e-15
    assert abs(run.sensitivity["y0"][1, 0, 0] + 0.5) <= 1e-15


def robertson(t, y, yp, k):
    slow, fast = k[0] * y[0], k[1] * y[1] * y[2]
    return [yp[0] + slow - fast, yp[1] - slow + fast + k[2] * y[1] ** 2, y[0] + y[1] + y[2] - 1]


def robertsons_rates(t, y, k):
    slow, fast, formed = k[0] * y[0], k[1] * y[1] * y[2], k[2] * y[1] ** 2
    return np.array([fast - slow, slow - fast - formed, formed])


def test_robertson_by_complex_steps():
    k, times = np.array([0.04, 1e4, 3e7]), [0.1, 0.4]
    run = solve_dae(
        robertson, (0, 0.4), [1, 0, 0], args=(k,), rtol=1e-9, atol=1e-14, t_eval=times,
        sensitivity="k",
    )  # fmt: skip
    for j in range(3):
        moved = k + 1j * H * (np.arange(3) == j)
        start = np.array([1, 0, 0], complex)
        exact = scipys(
            robertsons_rates, (0, 0.4), start, "DOP853", times, args=(moved,), rtol=1e-10,
            atol=1e-16,
        ).y.imag / H  # fmt: skip
        assert np.abs(run.sensitivity["k"][:, j] / exact - 1).max() <= 1e-6
    late = solve_dae(
        robertson, (0, 4e5), [1, 0, 0], args=(k,), rtol=1e-6, atol=1e-14, sensitivity="k"
    )
    assert late.success and np.abs(late.sensitivity["k"].sum(axis=0)).max() <= 1e-9


def decay(t, y, yp, k, limit):
    return [yp[0] + k * y[0], y[1] - y[0] ** 2]


def reaches(t, y, k, limit):
    return y[1] - limit


def test_the_time_of_an_event_and_the_state_there():
    """Here y^2 = exp(-2 k t) y0^2 reaches the limit at t = log(y0^2 / limit) / (2 k)."""
    values = 0.7, 0.3, 1.0
    run = solve_dae(
        decay, (0, 5), [1.0, 1.0], args=values[:2], events=reaches, sensitivity=("args", "y0"),
        **TIGHT,
    )  # fmt: skip
    at = run.event_sensitivity[0]
    found = at.t["k"], at.t["limit"], at.t["y0"][0]

    def time(k, limit, start):
        return np.log(start**2 / limit) / (2 * k)

    for j, each in enumerate(found):
        assert each.shape == (1,) and abs(each[0] - by_complex_step(time, values, j)) <= 1e-7
    assert np.abs(at.y["limit"][:, 0] - [0.5 / math.sqrt(0.3), 1]).max() <= 1e-8
    assert np.abs(at.y["k"]).max() <= 1e-8 and np.abs(at.y["y0"]).max() <= 1e-8
    assert run.y_events[0].shape == run.yp_events[0].shape == (1, 2)


def test_an_action_of_an_event():
    """Where the event occurs, y is raised by its limit: the saltation of what the event decides."""

    def raised(t, y, k, limit):
        return [y[0] + limit * math.exp(-t), y[1]]

    def end(k, limit, start):
        t = np.log(start / np.sqrt(limit)) / k
        y = (np.sqrt(limit) + limit * np.exp(-t)) * np.exp(-k * (1.1 - t))
        return np.array([y, y**2])

    values = 0.7, 0.3, 1.0
    run = solve_dae(
        decay, (0, 1.1), [1.0, 1.0], args=values[:2], events=reaches, on_event=raised,
        sensitivity=("args", "y0"), **TIGHT,
    )  # fmt: skip
    assert len(run.t_events[0]) == 1
    found = run.sensitivity["k"], run.sensitivity["limit"], run.sensitivity["y0"][:, 0]
    for j, each in enumerate(found):
        assert np.abs(each[:, -1] - by_complex_step(end, values, j)).max() <= 1e-7


def test_a_schedule_that_acts():
    run = solve_dae(
        decay, (0, 1), [1.0, 1.0], args=(0.7, 0.3), at=[0.5], sensitivity="limit", **TIGHT,
        on_event=lambda t, y, k, limit: [y[0] * limit, 0.0],
    )  # fmt: skip
    y = 0.3 * math.exp(-0.7)
    assert np.abs(run.sensitivity["limit"][:, -1] - [y / 0.3, 2 * y * y / 0.3]).max() <= 1e-8


def test_breakpoints():
    """At t = 1 the resistance changes, and the current jumps: y1 = -y0 / R."""

    def charge(t, y, yp, before, behind):
        resistance = before if t < 1 else behind
        return [yp[0] - y[1], resistance * y[1] + y[0]]

    def end(before, behind, start):
        y = start * np.exp(-1 / before - 1 / behind)
        return np.array([y, -y / behind])

    values = 2.0, 0.5, 1.0
    run = solve_dae(
        charge, (0, 2), [1.0, -0.5], args=values[:2], breakpoints=[1.0],
        sensitivity=("args", "y0"), **TIGHT,
    )  # fmt: skip
    found = run.sensitivity["before"], run.sensitivity["behind"], run.sensitivity["y0"][:, 0]
    for j, each in enumerate(found):
        assert np.abs(each[:, -1] - by_complex_step(end, values, j)).max() <= 1e-7
    at = np.flatnonzero(run.t == 1.0)
    jump = np.diff(run.sensitivity["behind"][1, at])[0]
    assert abs(jump - math.exp(-0.5) / 0.25) <= 1e-8


def test_decisions_without_a_jump():
    """F has a decision, and is continuous where the solution passes it: y' = -k max(y, 0.5)."""

    def braked(t, y, yp, k):
        speed = k * y[0] if y[0] > 0.5 else k * 0.5
        return [yp[0] + speed, y[1] - 2 * y[0]]

    run = solve_dae(
        braked, (0, 2), [1.0, 2.0], args=(0.7,), sensitivity="k", t_eval=[0.5, 2.0], **TIGHT
    )
    passed = math.log(2) / 0.7
    exact = [-0.5 * math.exp(-0.35), -passed * 0.35 / 0.7 - 0.5 * (2 - passed)]
    assert np.abs(run.sensitivity["k"][0] - exact).max() <= 1e-7
    assert np.abs(run.sensitivity["k"][1] - 2 * run.sensitivity["k"][0]).max() <= 1e-12


def tied(t, y, yp, k):
    return [yp[0] + yp[1] + k * y[0], y[0] - y[1]]


def test_components_that_cannot_be_varied_one_by_one():
    with pytest.raises(ValueError, match=r"by 'y0' has no start .*equation 1 .*Hold fewer"):
        solve_dae(tied, (0, 1), [1.0, 1.0], args=(0.7,), sensitivity="y0")
    run = solve_dae(tied, (0, 2), [1.0, 1.0], args=(0.7,), given=[0], sensitivity="y0", **TIGHT)
    y = math.exp(-0.7)
    assert np.abs(run.sensitivity["y0"][:, :, -1] - [[y, 0], [y, 0]]).max() <= 1e-8


def test_numbers_of_any_direction_backwards():
    run = solve_dae(decay, (1, 0), [1.0, 1.0], args=(0.7, 0.3), sensitivity="k", **TIGHT)
    y = math.exp(0.7)
    assert np.abs(run.sensitivity["k"][:, -1] - [y, 2 * y * y]).max() <= 1e-7


def sticking(t, y, yp, k, limit):
    return [yp[0] + k * np.sign(y[0]), y[1] - y[0]]


def keeps(t, y, d, *args):
    return y, d


REFUSED = [
    ("'kk'` is unknown; choose from 'y0', 'args', 'k', 'limit'", {"sensitivity": "kk"}),
    ("can be traced", {"F": lambda t, y, yp, *p: [yp[0] + float(str(y[0])), y[1] - y[0]]}),
    ("`F` jumps at t = 1.4", {"F": sticking}),
    ("do not go together", {"discrete": [1.0], "every": 0.1, "on_event": keeps}),
    ("can be traced and differentiated", {
        "at": [0.5], "on_event": lambda t, y, *p: [float(str(y[0])), 0.0]}),
]  # fmt: skip


@pytest.mark.hunt
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("said, changed", REFUSED)
def test_what_has_no_sensitivities_is_refused(said, changed):
    given = {
        "F": decay, "t_span": (0, 1.6), "y0": [1.0, 1.0], "args": (0.7, 0.3), "sensitivity": "args",
        **TIGHT, **changed,
    }  # fmt: skip
    with pytest.raises(ValueError, match=said):
        solve_dae(**given)
