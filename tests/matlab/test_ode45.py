"""ode45 and ode23 as MATLAB's scripts call them: output, events, mass, output functions."""

import math

import numpy as np
import pytest

from fastdyn import SingularMatrixError, solve_ivp
from fastdyn.matlab import deval, ode23, ode45, odeset
from support.motions import satellite

CIRCLE = [1.0, 0.0, 0.0, 1.0]
EPS = float(np.finfo(float).eps)


def fall(t, y):
    return [y[1], -9.81]


def lands(t, y):
    return y[0], 1, -1


def test_the_output_has_a_row_a_time_and_four_times_a_step():
    t, y = ode45(satellite, [0, 100], CIRCLE)
    assert t.shape == (677,) and y.shape == (677, 4)  # 169 steps, each in four
    steps = solve_ivp(satellite, (0, 100), CIRCLE, "ode45", dense_output=True)
    assert np.array_equal(t[::4], steps.t) and np.array_equal(y[::4].T, steps.y)
    quarter = t[:-1].reshape(-1, 4) - t[:-1:4, None]
    assert np.allclose(quarter / np.diff(t[::4])[:, None], [0, 0.25, 0.5, 0.75], rtol=0, atol=1e-9)
    assert np.array_equal(y.T[:, 1::4], steps.sol(t[1::4]))
    assert len(ode45(satellite, [0, 100], CIRCLE, odeset("Refine", 1)).x) == 170
    t, _ = ode45(satellite, [0, 100], CIRCLE, odeset("Refine", 1))
    assert np.array_equal(t, steps.t)


def test_the_struct_has_a_column_a_step_and_deval_knows_what_lies_between():
    sol = ode45(satellite, [0, 100], CIRCLE)
    assert sol.x.shape == (170,) and sol.y.shape == (4, 170) and sol.xe is None
    assert sol.stats == {"nsteps": 169, "nfailed": 0, "nfevals": 6 * 169 + 1}
    t, y = sol
    assert np.array_equal(deval(sol, t).T[1::4], y[1::4])
    assert np.array_equal(deval([1.0, 2.0], sol, [1]), deval(sol, [1.0, 2.0])[[1]])
    assert deval(sol, 3.0, 0) == deval(sol, 3.0)[0]
    with pytest.raises(ValueError, match="from 0 to 100"):
        deval(sol, [0.0, 100.5])
    with pytest.raises(TypeError, match="deval takes what"):
        deval(t, t)


def test_more_than_two_times_confine_the_output_and_leave_the_steps():
    times = [0, 10, 50, 99, 100]
    sol = ode45(satellite, times, CIRCLE)
    t, y = sol
    assert np.array_equal(t, times) and np.array_equal(y[-1], sol.y[:, -1])
    assert np.array_equal(sol.x, ode45(satellite, [0, 100], CIRCLE).x)
    back, y = ode45(satellite, times[::-1], CIRCLE)
    assert np.array_equal(back, times[::-1]) and np.array_equal(y[0], CIRCLE)


def test_published_counts_of_both_solvers():
    """MathWorks' page of ode23: y' = -1000 y, 0 to 2, steps, failures and evaluations of each."""
    published = {ode45: (615, 35, 3901), ode23: (822, 2, 2473)}
    for solver, counts in published.items():
        sol = solver(lambda t, y: -1000.0 * y, [0, 2], 1)
        assert tuple(sol.stats.values()) == counts
    t, _ = ode23(satellite, [0, 1], CIRCLE)
    assert len(t) == len(ode23(satellite, [0, 1], CIRCLE).x)  # Refine is 1


def test_steps_are_bounded_as_asked():
    sol = ode45(satellite, [0, 100], CIRCLE)
    assert np.diff(sol.x).max() <= 10.0
    short = ode45(satellite, [0, 100], CIRCLE, odeset("MaxStep", 0.25, "InitialStep", 1e-4))
    assert np.diff(short.x).max() <= 0.25 * (1 + 1e-9) and short.x[1] <= 1e-4


def test_an_event_ends_the_run_where_the_formula_says():
    options = odeset("Events", lands, "RelTol", 1e-8)
    t, y, te, ye, ie = ode45(fall, [0, 10], [0, 20], options)
    assert te == pytest.approx([2 * 20 / 9.81], rel=1e-12) and list(ie) == [0]
    assert t[-1] == te[0] and np.array_equal(y[-1], ye[0]) and ye.shape == (1, 2)
    sol = ode45(fall, [0, 10], [0, 20], options)
    assert (len(t) - 1) % 4 == 0 and sol.ye.shape == (2, 1)
    t, y, te, ye, _ = ode45(fall, [0, 1, 2, 3, 4, 5, 6], [0, 20], options)
    assert np.array_equal(t[:-1], [0, 1, 2, 3, 4]) and t[-1] == te[0]
    assert np.array_equal(y[-1], ye[0])


def test_events_come_in_the_order_of_time_with_their_indices():
    def axes(t, w):
        return [w[1], w[0]], [0, 0], [1, 0]

    options = odeset("Events", axes, "RelTol", 1e-9, "AbsTol", 1e-12)
    for tspan, quarters in (([0, 8], [0, 1, 3, 4, 5]), ([0, -8], [-1, -2, -3, -5])):
        _, _, te, ye, ie = ode45(satellite, tspan, CIRCLE, options)
        assert te == pytest.approx(0.5 * math.pi * np.array(quarters), abs=1e-6)
        assert [abs(q) % 2 for q in quarters] == list(ie)
        assert np.abs(np.choose(ie, ye.T[[1, 0]])).max() <= 1e-14


def test_an_event_in_the_first_step_ends_nothing():
    first = ode45(fall, [0, 1], [1e-9, -1], odeset("Events", lands))
    assert list(first.ie) == [0] and first.x[-1] == 1.0
    both = ode45(fall, [0, 1], [1e-9, -1], {"Events": lambda t, y: ([y[0], y[0]], [1, 1], [0, 0])})
    assert sorted(both.ie) == [0, 1] and both.x[-1] == 1.0


@pytest.mark.parametrize(
    ("events", "error", "sentence"),
    [
        (lambda t, y: y[0], TypeError, "must return value, isterminal, direction"),
        (lambda t, y: (y[0], [1, 0], 0), ValueError, r"of one length; got \[1, 2, 1\]"),
        (lambda t, y: (y[0], 2, 0), ValueError, "isterminal must be 0 or 1"),
        (lambda t, y: (y[0] + 9, 0, 1 if t < 0.5 else -1), ValueError, "change at t = 0.5"),
        (lambda t, y: (max(0.0, y[0] - 2), 0, 0), ValueError, "event 0 is exactly zero over"),
    ],
)
def test_events_that_mean_nothing_get_a_sentence(events, error, sentence):
    with pytest.raises(error, match=sentence):
        ode45(fall, [0, 1], [1, 0], odeset("Events", events))


def test_an_output_function_sees_each_step_and_may_stop():
    seen = []

    def output(t, y, flag):
        seen.append((flag, t, y))
        return len(seen) == 4

    t, y = ode45(satellite, [0, 100], CIRCLE, odeset("OutputFcn", output, "OutputSel", [1, 0]))
    assert [flag for flag, *_ in seen] == ["init", "", "", "", "done"]
    assert np.array_equal(seen[0][1], [0, 100]) and np.array_equal(seen[0][2], [0, 1])
    assert np.array_equal(np.concatenate([t for _, t, _ in seen[1:4]]), t[1:])
    shown = np.concatenate([y for _, _, y in seen[1:4]], axis=1)
    assert np.allclose(shown, y[1:, [1, 0]].T, rtol=0, atol=2 * EPS)
    whole, _ = ode45(satellite, [0, 100], CIRCLE)
    assert np.array_equal(t, whole[: len(t)]) and len(t) == 13
    seen.clear()
    ode45(satellite, [0, 1, 2, 50], CIRCLE, odeset("OutputFcn", output))
    assert np.array_equal(np.concatenate([t for _, t, _ in seen[1:-1]]), [1, 2, 50])


def test_what_an_output_function_changes_is_seen_by_the_equations():
    push = 0.0

    def rate(t, y):
        return [push]

    def output(t, y, flag):
        nonlocal push
        push = 1.0 if flag == "" and t[-1] >= 1.0 else 0.0

    _, y = ode45(rate, [0, 2], 0, odeset("OutputFcn", output, "MaxStep", 0.25))
    assert 0.5 < y[-1, 0] <= 1.0


@pytest.mark.parametrize(
    "mass",
    [
        [[2.0, 1.0], [0.0, 4.0]],
        lambda t: [[2.0, 1.0], [0.0, 4.0]],
        lambda t, y: np.array([[2.0, 1.0], [0.0 * y[0], 4.0]]),
    ],
)
def test_a_mass_matrix_is_divided_by(mass):
    """M y' = A y, against the same equation divided by hand."""
    A = np.array([[0.0, 2.0], [-4.0, 0.0]])
    divided = np.linalg.solve([[2.0, 1.0], [0.0, 4.0]], A)
    options = odeset("RelTol", 1e-9, "AbsTol", 1e-12)
    t, y = ode45(lambda t, y: A @ y, [0, 5], [1, 0], odeset(options, "Mass", mass))
    same, z = ode45(lambda t, y: divided @ y, [0, 5], [1, 0], options)
    assert len(t) == len(same) and np.abs(y - z).max() <= 1e-10


def test_a_mass_that_depends_on_the_time():
    _, y = ode45(lambda t, y: [1.0], [0, 1], 0, odeset("Mass", lambda t: [[1 + t]], "Rel", 1e-9))
    assert y[-1, 0] == pytest.approx(math.log(2), abs=1e-9)
    with pytest.raises(SingularMatrixError, match="no algebraic equations"):
        ode45(fall, [0, 1], [0, 1], odeset("Mass", np.zeros((2, 2))))
    with pytest.raises(ValueError, match=r"shape \(2, 2\)"):
        ode45(fall, [0, 1], [0, 1], odeset("Mass", [1.0, 2.0]))
    with pytest.raises(ValueError, match="MStateDependence is 'none'"):
        ode45(fall, [0, 1], [0, 1], odeset("Mass", np.eye(2), "MStateDep", "some"))


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        ({"tspan": [0, 0]}, ValueError, "must be different from the first"),
        ({"tspan": [0, 2, 1]}, ValueError, "strictly increase, or decrease"),
        ({"tspan": 5}, ValueError, "two or more finite times"),
        ({"tspan": [0, math.inf]}, ValueError, "two or more finite times"),
        ({"y0": [1j, 0]}, ValueError, "`y0` must be real"),
        ({"y0": []}, ValueError, "`y0` must be real, and hold a number"),
        ({"options": odeset("NonNegative", [0, 2])}, ValueError, "list each component once"),
        ({"options": odeset("NonNegative", [0], "Mass", np.eye(2))}, ValueError, "do not go"),
        ({"options": odeset("NormControl", "on")}, ValueError, "NormControl is no option"),
        (
            {"options": 1e-5},
            TypeError,
            r"`options` must be what `odeset\(...\)` returns, or a dict",
        ),
        ({"odefun": "fall"}, TypeError, "must be a function of"),
    ],
)
def test_wrong_calls_get_a_sentence(given, error, sentence):
    with pytest.raises(error, match=sentence):
        ode45(**({"odefun": fall, "tspan": [0, 1], "y0": [0, 1]} | given))


def test_a_failure_warns_and_returns_what_there_is(capsys):
    with pytest.warns(UserWarning, match="Failure in ode45"):
        sol = ode45(lambda t, y: [1 / (t - 2)], [0, 2], 5, odeset("Stats", "on"))
    assert 1.9 < sol.x[-1] <= 2.0
    assert "failed attempts" in capsys.readouterr().out


def test_columns_and_single_numbers_are_states_too():
    _, y = ode45(lambda t, y: -y, [0, 1], np.array([[1.0], [2.0]]))
    assert y.shape[1] == 2
