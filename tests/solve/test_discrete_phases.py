"""Claims about discrete states that are carried from phase to phase."""

import math

import numpy as np
import pytest

from fastdyn import Phase, solve_phases
from tests.support.impacts import marked

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def flight(t, y, d, e):
    return [y[1], -9.81]


def landing(t, y, d, e):
    return y[0]


LANDING = marked(landing, terminal=True, direction=-1)


def bounced(t, y, d, e):
    """Each bounce is counted, and the height before it is kept."""
    return "flight", [0.0, -e * y[1]], [d[0] + 1.0, y[1] ** 2 / 19.62]


BALL = {"flight": Phase(flight, LANDING, bounced)}


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Taylor", "Radau"])
def test_bounces_are_counted(method):
    run = solve_phases(
        BALL, "flight", (0.0, 2.0), [1.0, 0.0], method, discrete=[0.0, 1.0], args=(0.8,),
        dense_output=True, **TIGHT,
    )  # fmt: skip
    first = math.sqrt(2.0 / 9.81)
    times = first * (1.0 + 2.0 * np.cumsum([0.0, 0.8, 0.8**2, 0.8**3]))
    times = times[times < 2.0]
    assert run.discrete[0, -1] == len(times) == len(run.phases) - 1
    assert run.discrete[1, -1] == pytest.approx(0.64 ** (len(times) - 1), abs=1e-8)
    assert run.y.shape[0] == 2 and run.discrete.shape == (2, len(run.t))
    assert run.sol(1.0).shape == (2,)
    twice = np.flatnonzero(np.diff(run.t) == 0.0)
    assert np.array_equal(run.discrete[0, twice + 1], run.discrete[0, twice] + 1.0)


def test_equations_and_events_see_them():
    """A gait: the step length is kept from impact to impact, and shrinks."""

    def rolling(t, y, d):
        return [d[0]]

    done = marked(lambda t, y, d: y[0] - 1.0, terminal=True)
    half = marked(lambda t, y, d: y[0] - 0.5 * d[0])
    walk = {"step": Phase(rolling, done, lambda t, y, d: ("step", [0.0], [0.5 * d[0]]))}
    run = solve_phases(
        walk, "step", (0.0, 14.0), [0.0], events=half, discrete=[1.0], t_eval=[0.5, 2.0, 13.0],
        **TIGHT,
    )  # fmt: skip
    assert [start for _, start, _ in run.phases] == pytest.approx([0.0, 1.0, 3.0, 7.0])
    assert run.t_events[0] == pytest.approx([0.5, 1.5, 3.5, 7.5])
    assert run.discrete_events[0][:, 0] == pytest.approx([1.0, 0.5, 0.25, 0.125])
    assert run.discrete[0] == pytest.approx([1.0, 0.5, 0.125])
    assert run.y[0] == pytest.approx([0.5, 0.5, 0.75])


def test_options_of_a_phase_are_of_the_state_alone():
    def still(t, y, d):
        return [-y[0], -2.0 * y[1]]

    kept = Phase(
        still, marked(lambda t, y, d: y[0] - 0.5, terminal=True),
        lambda t, y, d: ("rest", y, [1.0]), {"rtol": 1e-8, "atol": [1e-10, 1e-9]},
    )  # fmt: skip
    rest = Phase(still, marked(lambda t, y, d: y[0] + 1.0, terminal=True), kept.after)
    run = solve_phases(
        {"first": kept, "rest": rest}, "first", (0.0, 1.0), [1.0, 1.0], discrete=[0.0],
        method="Radau", jac=lambda t, y, d: [[-1.0, 0.0], [0.0, -2.0]],
    )  # fmt: skip
    assert run.t[np.argmax(run.discrete[0] > 0.0)] == pytest.approx(math.log(2.0), abs=1e-6)
    assert run.success and run.discrete[0, -1] == 1.0


def test_wrong_answers_of_after_are_sentences():
    for answer in (("flight", [0.0, 1.0]), ("flight", [0.0, 1.0], [1.0]), "flight", None):
        wrong = {"flight": Phase(flight, LANDING, lambda t, y, d, e, found=answer: found)}
        with pytest.raises(ValueError, match=r"must return \(name, y, d\), with 2 and 2 numbers"):
            solve_phases(wrong, "flight", (0.0, 2.0), [1.0, 0.0], discrete=[0.0, 0.0], args=(0.8,))
    with pytest.raises(ValueError, match="one number at least"):
        solve_phases(BALL, "flight", (0.0, 2.0), [1.0, 0.0], discrete=[], args=(0.8,))
