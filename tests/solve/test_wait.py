"""The attribute `wait` of an event, in all ways of solving: the occurrences are those of the same
event without `wait`, thinned in order."""

import pickle

import numpy as np
import pytest
from scipy.integrate import RK45

import fastdyn
from fastdyn import Phase, Stepper, prepare, solve_dae, solve_ensemble, solve_ivp, solve_phases
from fastdyn.problem.events import OTHER_ATTRIBUTES, RULES, Event
from support.steppers import ended

END, WAIT = 40.0, 4.0  # a crossing every pi: each second one counts
ALL = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "Tsit5", "Vern7", "Vern9", "Rodas5P",
       "Taylor", "ode45", "ode23", "auto")  # fmt: skip


def turning(t, y, k=1.0):
    return [y[1], -k * y[0]]


def crossing(wait=None, direction=None, terminal=None):
    def level(t, y, k=1.0):
        return y[0] - 0.25

    for name, value in (("wait", wait), ("direction", direction), ("terminal", terminal)):
        if value is not None:
            setattr(level, name, value)
    return level


def thinned(times, wait=WAIT):
    found = []
    for t in times:
        if not found or abs(t - found[-1]) >= wait:
            found.append(t)
    return np.array(found)


def solved(method="Tsit5", event=None, **how):
    how = {"rtol": 1e-7, "atol": 1e-9, **how}
    return solve_ivp(turning, (0, END), [1.0, 0.0], method, events=event or crossing(WAIT), **how)


def every(method="Tsit5", **how):
    """All times of the event without `wait`."""
    found = solved(method, crossing(), **how).t_events[0]
    assert len(found) > 1.5 * len(thinned(found)) > 0
    return found


@pytest.mark.parametrize("method", ALL)
def test_each_method_thins_its_occurrences_at_once_and_again(method):
    expected = thinned(every(method))
    for _ in range(4):
        assert np.array_equal(solved(method).t_events[0], expected)


@pytest.mark.parametrize("how", [{"step": 0.05}, {"step": 0.07}])
@pytest.mark.parametrize("method", ["RK4", "Gauss8"])
def test_constant_steps_thin_their_occurrences(method, how):
    plain = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=crossing(), **how)
    found = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=crossing(WAIT), **how)
    assert np.array_equal(found.t_events[0], thinned(plain.t_events[0]))


def test_a_wait_that_changes_between_calls_holds_at_once():
    event, all_times = crossing(), every()
    for wait in (0.0, 4.0, 4.0, 4.0, 7.0, 4.0, 0.0, 0.0, np.inf, 4.0):
        event.wait = wait
        assert np.array_equal(solved(event=event).t_events[0], thinned(all_times, wait))


def test_only_the_crossings_of_its_direction_keep_an_event_waiting():
    rising = solved(event=crossing(direction=1)).t_events[0]
    assert np.array_equal(solved(event=crossing(7.0, 1)).t_events[0], thinned(rising, 7.0))


def test_a_number_of_occurrences_counts_those_that_count():
    found = solved(event=crossing(WAIT, terminal=3))
    assert found.status == 1 and np.array_equal(found.t_events[0], thinned(every())[:3])


def test_backwards():
    def of(event):
        return solve_ivp(turning, (END, 0), [1.0, 0.0], "Tsit5", events=event).t_events[0]

    assert np.array_equal(of(crossing(WAIT)), thinned(of(crossing())))


def test_in_python():
    with pytest.warns(fastdyn.CompileWarning):
        found = solve_ivp(
            lambda t, y: [y[1], -y[0] + 0 * len(str(y[0]))], (0, END), [1.0, 0.0], "Tsit5",
            events=crossing(WAIT), rtol=1e-7, atol=1e-9,
        )  # fmt: skip
    assert np.allclose(found.t_events[0], thinned(every()), rtol=0, atol=1e-6)


def kicked(t, y, k=1.0):
    return [y[0], 1.01 * y[1]]


@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Taylor", "Rodas5P", "Radau", "BDF"])
def test_an_occurrence_that_does_not_count_does_not_act(method):
    found = solved(method, on_event=kicked)
    t = found.t_events[0]
    assert len(t) > 3 and (np.diff(t) >= WAIT).all()
    assert np.array_equal(found.t[np.flatnonzero(np.diff(found.t) == 0.0)], t)
    begin, y, most = 0.0, [1.0, 0.0], 1e-4 if method == "BDF" else 1e-5
    for expected in t:  # each leg by itself, to the first crossing that may count
        leg = solve_ivp(
            turning, (begin, END), y, "DOP853", rtol=1e-11, atol=1e-12, events=crossing()
        )
        times = leg.t_events[0]
        first = np.flatnonzero((times - begin >= WAIT) | (begin == 0.0))[0]
        assert abs(times[first] - expected) < most
        begin, y = times[first], kicked(0.0, leg.y_events[0][first])


def test_two_events_at_one_time_wait_each_for_itself():
    waits, always = crossing(WAIT), crossing()
    found = solved(event=[waits, always], on_event=[None, lambda t, y: [y[0], y[1]]])
    assert np.array_equal(found.t_events[0], thinned(found.t_events[1]))


def test_an_event_that_waits_at_the_time_of_a_schedule():
    found = solved(event=[crossing(WAIT)], at=every()[1:4], on_event=[None, lambda t, y: y])
    assert np.allclose(found.t_events[0], thinned(every()), rtol=0, atol=1e-6)


@pytest.mark.few
@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Taylor", "Rodas5P"])
@pytest.mark.parametrize("simd", [True, False])
def test_members_of_an_ensemble_wait_each_for_itself(method, simd):
    k = np.linspace(0.8, 1.3, 20)
    how = {"rtol": 1e-7, "atol": 1e-9}
    many = solve_ensemble(
        turning, (0, END), [1.0, 0.0], (k,), method, events=crossing(WAIT), simd=simd, **how
    )
    plain = solve_ensemble(
        turning, (0, END), [1.0, 0.0], (k,), method, events=crossing(), simd=simd, **how
    )
    for found, times in zip(many.t_events[0], plain.t_events[0], strict=True):
        assert np.array_equal(found, thinned(times))


def test_blocks_of_an_ensemble_wait():
    from concurrent.futures import ThreadPoolExecutor

    k = np.linspace(0.8, 1.3, 9)
    given = turning, (0, 20.0), [1.0, 0.0], (k,), "Tsit5"
    with ThreadPoolExecutor(1) as client:
        found = solve_ensemble(*given, events=crossing(WAIT), client=client, block=4)
    here = solve_ensemble(*given, events=crossing(WAIT))
    for a, b in zip(found.t_events[0], here.t_events[0], strict=True):
        assert np.array_equal(a, b) and (np.diff(a) >= WAIT).all()


@pytest.mark.parametrize("name", ["sensitivity", "adjoint"])
def test_derivatives_of_the_occurrences_that_count(name):
    how = {"args": (1.0,), "rtol": 1e-9, "atol": 1e-11, "on_event": kicked}

    def end(k):
        return solve_ivp(
            turning, (0, 15.0), [1.0, 0.0], "Tsit5", events=crossing(WAIT), **{**how, "args": (k,)}
        )

    for _ in range(3):
        found = solve_ivp(
            turning, (0, 15.0), [1.0, 0.0], "Tsit5", [15.0], events=crossing(WAIT), **how,
            **{name: ("k",)},
        )  # fmt: skip
        d = 1e-5
        slope = (end(1 + d).y[0, -1] - end(1 - d).y[0, -1]) / (2 * d)
        ours = (
            found.sensitivity["k"][0, -1] if name == "sensitivity"
            else found.vjp(np.array([[1.0], [0.0]]))["k"]
        )  # fmt: skip
        assert abs(ours - slope) < 1e-4
        assert np.array_equal(found.t_events[0], thinned(found.t_events[0]))
        if name == "sensitivity":
            moved = (end(1 + d).t_events[0] - end(1 - d).t_events[0]) / (2 * d)
            assert np.allclose(found.event_sensitivity[0].t["k"], moved, atol=1e-4)


def test_prepared_solvers_and_copies_of_them():
    solver = prepare(turning, (0, END), [1.0, 0.0], "Tsit5", events=crossing(WAIT), rtol=1e-7,
                     atol=1e-9)  # fmt: skip
    for _ in range(3):
        assert np.array_equal(solver().t_events[0], thinned(every()))


def test_a_stepper():
    stepper = Stepper(turning, 0.0, [1.0, 0.0], END, "Tsit5", events=crossing(WAIT), rtol=1e-7,
                      atol=1e-9)  # fmt: skip
    ended(stepper)
    assert np.array_equal(stepper.t_events[0], thinned(every()))


def test_a_run_that_goes_on_from_a_checkpoint(tmp_path):
    given = {"event": crossing(WAIT), "checkpoint": tmp_path / "run"}
    part = solved(max_steps=60, **given)
    assert part.status == -1 and len(part.t_events[0]) > 0
    assert np.array_equal(solved(**given).t_events[0], thinned(every()))


def test_phases_go_on_waiting():
    def after(name):
        return lambda t, y: (name, y)

    def tick(t, y):
        return np.sin(3.0 * t + 0.1)

    tick.terminal = True
    phases = {
        "a": Phase(lambda t, y: turning(t, y), tick, after("b")),
        "b": Phase(lambda t, y: turning(t, y), tick, after("a")),
    }
    how = {"method": "Tsit5", "rtol": 1e-7, "atol": 1e-9}
    plain = solve_phases(phases, "a", (0, END), [1.0, 0.0], events=_of_two(), **how)
    found = solve_phases(phases, "a", (0, END), [1.0, 0.0], events=_of_two(WAIT), **how)
    assert len(found.phases) > 10
    assert np.array_equal(found.t_events[0], thinned(plain.t_events[0]))


def _of_two(wait=0.0):
    def level(t, y):
        return y[0] - 0.25

    level.wait = wait
    return level


def test_with_discrete_states():
    def level(t, y, d):
        return y[0] - 0.25

    level.wait = WAIT
    found = solve_ivp(
        lambda t, y, d: [y[1], -y[0]], (0, END), [1.0, 0.0], "Tsit5", events=level, discrete=[0.0],
        on_event=lambda t, y, d: (y, [d[0] + 1]), rtol=1e-7, atol=1e-9,
    )  # fmt: skip
    assert np.allclose(found.t_events[0], thinned(every()), rtol=0, atol=1e-5)
    assert found.discrete[0, -1] == len(found.t_events[0])


def pendulum(t, y, yp):
    """A point on a circle, of index 3: x, y, u, v and the force."""
    x, z, u, v, force = y
    return [
        yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + 1.0, x * x + z * z - 1.0,
    ]  # fmt: skip


@pytest.mark.parametrize("index", [0, 3])
def test_differential_algebraic_equations(index):
    def level(t, y):
        return y[0] - 0.25

    if index == 0:
        given = (lambda t, y, yp: [yp[0] - y[1], yp[1] + y[0]]), (0, 20.0), [1.0, 0.0]
    else:
        given = pendulum, (0, 20.0), [np.sin(0.5), -np.cos(0.5), 0.0, 0.0, np.cos(0.5)]
    plain = solve_dae(*given, events=level).t_events[0]
    level.wait = WAIT
    found = solve_dae(*given, events=level).t_events[0]
    assert len(found) > 2 and np.array_equal(found, thinned(plain))


def test_along_a_switch():
    def relay(t, y):
        return [1.0 if y[0] < 0.5 else -1.0, 1.0]

    def tick(t, y):
        return np.sin(y[1])

    tick.wait = WAIT
    found = solve_ivp(relay, (0, 20.0), [0.0, 0.1], "auto", events=tick, max_step=0.5)
    assert np.allclose(found.t_events[0], np.arange(1, 7, 2) * np.pi - 0.1, atol=1e-6)


def writing(t, y):
    y[1] *= 0.5
    return [y[1], -y[0]]


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_solves_by_scipy_refuse_what_scipy_ignores():
    for fun, method in ((turning, type("Own", (RK45,), {})), (writing, "RK45")):
        with pytest.raises(ValueError, match="`wait` of the event `level` is for fastdyn's"):
            solve_ivp(fun, (0, 1.0), [1.0, 0.0], method, events=crossing(WAIT))


@pytest.mark.parametrize("wait", [-1.0, np.nan, "soon", None, [1.0, 2.0]])
def test_a_wait_that_is_no_time_is_refused(wait):
    event = crossing()
    event.wait = wait
    with pytest.raises(ValueError, match="`wait` attribute of each event must be a time"):
        solved(event=event)


@pytest.mark.parametrize(("word", "ours"), OTHER_ATTRIBUTES.items())
def test_a_name_of_other_packages_is_told(word, ours):
    event = crossing()
    setattr(event, word, 1.0)
    with pytest.warns(UserWarning, match=f"`{word}` of the .* has no .* did you mean `{ours}`"):
        solved(event=event)


def test_calls_again_with_an_event_of_other_rules_follow_it():
    event = Event.of(crossing())
    others = {"limit": 2, "direction": -1.0, "wait": WAIT}
    assert others.keys() == RULES.keys()
    for name, value in others.items():
        changed = event.changed(**{name: value})
        plain, *again = [
            solved(event=each).t_events[0] for each in (event, changed, event, changed)
        ]
        assert len(again[0]) < len(plain)
        assert np.array_equal(again[1], plain) and np.array_equal(again[2], again[0])
        assert changed.beyond() == {name: value} and changed.beyond(name) == {}


def test_an_event_is_one_record():
    given = crossing(WAIT, -1, 3)
    event = Event.of(given)
    assert Event.of(event) is event
    longer = event.like(lambda t, z: 0.0)
    assert longer.rules == event.rules and longer.asked == event.asked
    assert (event.limit, event.direction, event.wait) == (3, -1.0, WAIT)
    assert pickle.loads(pickle.dumps(Event.of(len))).rules["wait"] == 0.0
