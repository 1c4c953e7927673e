"""Claims about schedules: times known beforehand, by motions with exact solutions."""

import math
import pickle

import numpy as np
import pytest
from scipy.integrate import OdeSolver
from scipy.linalg import expm

from fastdyn import METHODS, at, every, prepare, solve_ivp, solve_phases
from fastdyn.solve import solve_second_order

ONE_STATE = [name for name, method in METHODS.items() if not method.second_order]
DOSES, AMOUNT, RATE = np.array([0.0, 1.0, 2.5, 4.0]), 10.0, 0.3
TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def eliminated(t, y, k):
    return [-k * y[0]]


def dose(t, y, k):
    return [y[0] + AMOUNT]


def concentration(t, doses=DOSES):
    """The exact amount at times t, before a dose at these times."""
    t = np.asarray(t)[..., None]
    return np.where(t > doses, AMOUNT * np.exp(-RATE * (t - doses)), 0.0).sum(axis=-1)


def options_of(method):
    return {"step": 0.01} if not METHODS[method].error_order else {"rtol": 1e-8, "atol": 1e-10}


@pytest.mark.parametrize("method", ONE_STATE)
def test_doses_are_given_at_their_times(method):
    t = np.linspace(0.0, 6.0, 13)
    given = {"at": DOSES, "on_event": dose, "args": (RATE,), **options_of(method)}
    run = solve_ivp(eliminated, (0.0, 6.0), [0.0], method, t_eval=t, dense_output=True, **given)
    assert run.success and np.array_equal(run.t_events[0], DOSES)
    tolerance = {"BDF": 5e-6, "LSODA": 5e-6, "EnergyConserving2": 2e-5}.get(method, 1e-6)
    assert np.abs(run.y[0] - concentration(t)).max() <= tolerance
    assert np.abs(run.sol(t[1:])[0] - concentration(t[1:])).max() <= 10 * tolerance
    assert np.abs(run.y_events[0][:, 0] - concentration(DOSES)).max() <= tolerance
    steps = solve_ivp(eliminated, (0.0, 6.0), [0.0], method, **given)
    twice = np.flatnonzero(np.diff(steps.t) == 0.0)
    assert np.array_equal(steps.t[twice], DOSES)
    assert np.array_equal(steps.y[0, twice + 1], steps.y[0, twice] + AMOUNT)


@pytest.mark.parametrize("method", ["RK45", "BDF", "Taylor", "RK4", "Gauss4"])
def test_steps_of_any_size_reach_the_times(method):
    options = {**options_of(method), **({"step": 0.013} if method in ("RK4", "Gauss4") else {})}
    run = solve_ivp(eliminated, (0.0, 6.0), [1.0], method, every=0.7, args=(RATE,), **options)
    times = np.arange(9) * 0.7
    assert np.array_equal(run.t_events[0], times) and np.isin(times, run.t).all()
    assert np.allclose(run.y_events[0][:, 0], np.exp(-RATE * times), atol=1e-5)
    assert np.count_nonzero(np.diff(run.t) == 0.0) == 0  # nothing acts


def test_times_at_equal_distances_are_products():
    run = solve_ivp(eliminated, (0.0, 100.0), [1.0], every=0.1, args=(RATE,))
    assert np.array_equal(run.t_events[0], np.arange(1000) * 0.1)
    later = solve_ivp(eliminated, (0.0, 1.0), [1.0], every=[0.25, 0.5], args=(RATE,))
    assert [len(times) for times in later.t_events] == [4, 2]


def test_times_run_backwards():
    span, given = (6.0, 0.5), {"args": (RATE,), **TIGHT}
    end = concentration(6.0)
    for events in (at(DOSES[1:]), every(1.5, start=1.0)):
        times = DOSES[1:] if events.times is not None else np.array([1.0, 2.5, 4.0, 5.5])
        run = solve_ivp(
            eliminated, span, [end], events=events, on_event=lambda t, y, k: y - AMOUNT, **given
        )
        assert np.array_equal(run.t_events[0], times[::-1])
        grown = end * np.exp(RATE * 5.5) - (AMOUNT * np.exp(RATE * (times - 0.5))).sum()
        assert run.y[0, -1] == pytest.approx(grown, rel=1e-8)
    own = solve_ivp(eliminated, span, [1.0], every=2.0, **given)
    assert np.array_equal(own.t_events[0], [6.0, 4.0, 2.0])


def test_a_time_at_the_start_acts_and_one_at_the_end_is_left_to_the_next_run():
    given = {"on_event": dose, "args": (RATE,), **TIGHT}
    whole = solve_ivp(eliminated, (0.0, 6.0), [0.0], at=DOSES, **given)
    y = [0.0]
    for begin, end in ((0.0, 2.5), (2.5, 4.0), (4.0, 6.0)):
        times = DOSES[(DOSES >= begin) & (DOSES <= end)]
        part = solve_ivp(eliminated, (begin, end), y, at=times, **given)
        y = part.y[:, -1]
        assert np.array_equal(part.t_events[0], times[times < end])
    assert np.array_equal(y, whole.y[:, -1])
    parts = [solve_ivp(eliminated, s, [1.0], events=every(0.1, start=0.0), args=(RATE,))
             for s in ((0.0, 0.3), (0.3, 0.7), (0.7, 1.0))]  # fmt: skip
    assert np.array_equal(np.concatenate([p.t_events[0] for p in parts]), np.arange(10) * 0.1)


def test_schedules_stand_among_events_and_act_in_their_order():
    def level(t, y, k):
        return y[0] - 5.0

    events = [at([1.0, 3.0]), level, every(1.0)]
    jumps = [lambda t, y, k: y + 1.0, None, lambda t, y, k: 2.0 * y]
    run = solve_ivp(
        eliminated, (0.0, 3.5), [4.0], events=events, on_event=jumps, args=(RATE,), **TIGHT
    )
    a = [8.0 * math.exp(-RATE)]
    b = 2.0 * (a[0] + 1.0) * math.exp(-RATE)
    a.append(2.0 * b * math.exp(-RATE))
    assert np.allclose(run.y_events[0][:, 0], a, rtol=1e-8)
    assert np.allclose(run.y_events[2][:, 0], [4.0, a[0] + 1.0, b, a[1] + 1.0], rtol=1e-8)
    assert len(run.t_events[1]) == 0  # jumps carry the state over the level
    last = 2.0 * (a[1] + 1.0) * math.exp(-0.5 * RATE)
    assert run.y[0, -1] == pytest.approx(last, rel=1e-8)


def test_a_number_of_occurrences_ends_the_run():
    ticks = every(0.5)
    ticks.terminal = 3
    run = solve_ivp(eliminated, (0.0, math.inf), [1.0], events=ticks, args=(RATE,))
    assert run.status == 1 and run.t[-1] == 1.0 and np.array_equal(run.t_events[0], [0, 0.5, 1.0])
    ticks.terminal = True
    run = solve_ivp(eliminated, (0.0, 2.0), [1.0], events=ticks, on_event=dose, args=(RATE,))
    assert run.status == 0 and len(run.t_events[0]) == 4


@pytest.mark.parametrize("method", ["DOP853", "Radau", "BDF", "Taylor", "RK4"])
def test_a_sampled_input_is_that_of_matrix_exponentials(method):
    """A plant with an input held from sample to sample."""
    a, b, gain, period = np.array([[0.0, 1.0], [-2.0, -0.3]]), [0.0, 1.0], [1.3, 0.8], 0.05
    transition = expm(period * np.block([[a, np.c_[b]], [np.zeros((1, 3))]]))
    feedback = np.eye(3)
    feedback[2] = [-gain[0], -gain[1], 0.0]
    exact = [np.array([1.0, 0.0, 0.0])]
    for _ in range(40):
        exact.append(transition @ feedback @ exact[-1])

    def plant(t, y):
        return [y[1], -2.0 * y[0] - 0.3 * y[1] + y[2], 0.0]

    def sample(t, y):
        return [y[0], y[1], -gain[0] * y[0] - gain[1] * y[1]]

    options = {"step": period / 7} if method == "RK4" else {"rtol": 1e-11, "atol": 1e-13}
    run = solve_ivp(plant, (0.0, 2.0), exact[0], method, every=period, on_event=sample, **options)
    states = np.vstack([run.y_events[0], run.y[:, -1]])
    assert len(run.t_events[0]) in (40, 41)  # 40 * 0.05 is 2.0
    bound = {"RK4": 1e-7, "BDF": 1e-8}.get(method, 1e-9)
    assert np.abs(states[:41] - exact).max() <= bound


def test_breakpoints_at_the_times_of_a_schedule():
    def infused(t, y):
        return [-y[0] + (1.0 if t < 1.0 else 0.0)]

    run = solve_ivp(
        infused, (0.0, 2.0), [0.0], breakpoints=[1.0], at=[1.0], on_event=lambda t, y: y + 1.0,
        dense_output=True, **TIGHT,
    )  # fmt: skip
    assert run.n_rejected == 0 and np.array_equal(run.t_events[0], [1.0])
    assert run.y_events[0][0, 0] == pytest.approx(1.0 - math.exp(-1.0), abs=1e-9)
    assert run.y[0, -1] == pytest.approx((2.0 - math.exp(-1.0)) * math.exp(-1.0), abs=1e-9)


def test_kicks_in_second_order():
    """A comb of kicks on free motion."""
    run = solve_second_order(
        lambda t, q: 0.0 * q, (0.0, 5.0), [0.0], [1.0], step=0.01, every=1.0,
        on_event=lambda t, y: [y[0], y[1] + 1.0],
    )  # fmt: skip
    assert run.y[0, -1] == pytest.approx(2.0 + 3.0 + 4.0 + 5.0 + 6.0, abs=1e-12)


def test_prepared_solvers_keep_their_schedules():
    solver = prepare(eliminated, (0.0, 6.0), [0.0], at=DOSES, on_event=dose, args=(RATE,), **TIGHT)
    for solve in (solver, solver, pickle.loads(pickle.dumps(solver))):
        assert solve().y[0, -1] == pytest.approx(concentration(6.0), abs=1e-8)
    ends = solver.many(np.array([[0.0], [1.0]]))
    assert np.allclose(np.diff(ends.y[:, 0]), math.exp(-6.0 * RATE), atol=1e-8)


@pytest.mark.parametrize("method", ["RK45", "LSODA", "Taylor"])
def test_chunks_and_checkpoints_are_the_uninterrupted_run(method, tmp_path):
    given = {"at": DOSES, "every": 0.5, "args": (RATE,), "on_event": [dose, dose], **TIGHT}
    whole = solve_ivp(eliminated, (0.0, 6.0), [0.0], method, **given)
    file = tmp_path / "run"
    part = solve_ivp(eliminated, (0.0, 6.0), [0.0], method, checkpoint=file, max_steps=9, **given)
    assert part.status == -1
    rest = solve_ivp(eliminated, (0.0, 6.0), [0.0], method, checkpoint=file, **given)
    assert np.array_equal(rest.y, whole.y) and np.array_equal(rest.t, whole.t)
    assert all(map(np.array_equal, rest.t_events, whole.t_events))


def test_unused_schedules_leave_the_steps_as_they_are():
    plain = solve_ivp(eliminated, (0.0, 6.0), [1.0], args=(RATE,))
    none = solve_ivp(eliminated, (0.0, 6.0), [1.0], at=[], args=(RATE,))
    assert np.array_equal(plain.y, none.y) and none.t_events[0].size == 0


SENTENCES = [
    ({"at": [-1.0]}, ValueError, "before the start"),
    ({"at": [7.0]}, ValueError, "behind the end"),
    ({"at": [1.0, 1.0]}, ValueError, "is there twice"),
    ({"at": [2.0, 1.0]}, ValueError, "rising order"),
    ({"at": [1.0, math.nan]}, ValueError, "finite"),
    ({"at": 3.0}, TypeError, "a sequence of times"),
    ({"at": "now"}, (TypeError, ValueError), "at"),
    ({"at": [[1.0], [2.0]], "on_event": [dose]}, ValueError, "for each event"),
    ({"every": 0.0}, ValueError, "above zero"),
    ({"every": -1.0}, ValueError, "above zero"),
    ({"every": math.nan}, ValueError, "finite"),
    ({"every": math.inf}, ValueError, "finite"),
    ({"every": "day"}, TypeError, "number"),
    ({"every": 1e-17}, ValueError, "spacing"),
    ({"at": [1.0], "on_event": [dose, dose]}, ValueError, "for each event"),
    ({"at": [1.0], "on_event": 3}, TypeError, "on_event"),
    ({"at": [1.0], "callback": print}, ValueError, "callback"),
    ({"at": [1.0], "on_event": lambda t, y, k: [1.0, 2.0]}, ValueError, "on_event"),
    ({"events": [at([1.0])], "method": OdeSolver}, ValueError, "compiled"),
    ({"events": every(1.0, start=9.0)}, ValueError, "behind the span"),
    ({"events": every(1.0), "y0": [1.0 + 1j], "on_event": [dose]}, ValueError, "real"),
]


@pytest.mark.parametrize(("given", "error", "words"), SENTENCES)
def test_hostile_schedules_are_answered_by_sentences(given, error, words):
    given = {"y0": [1.0], "args": (RATE,), **given}
    with pytest.raises(error, match=words):
        solve_ivp(eliminated, (0.0, 6.0), **given)


def test_what_takes_no_schedule_says_so():
    with pytest.raises(ValueError, match="every"):
        solve_phases({}, "a", (0.0, 1.0), [1.0], every=0.1)
