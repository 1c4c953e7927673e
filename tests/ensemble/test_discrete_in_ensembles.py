"""Claims about discrete states in ensembles: each trajectory is the one of solve_ivp."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from fastdyn import at, every, solve_ensemble, solve_ivp
from tests.support.impacts import marked
from tests.support.thermostat import SWITCH, heated

TIGHT = {"rtol": 1e-9, "atol": 1e-12}
PERIOD, LIMIT = 0.05, 1.2
GAINS = np.linspace(1.0, 6.0, 19)


def plant(t, y, d, gain):
    return [y[1], -y[0] - 0.4 * y[1] + d[0]]


def controller(t, y, d, gain):
    wanted = gain * (1.0 - y[0]) + d[1]
    held = min(max(wanted, -LIMIT), LIMIT)
    return y, [held, d[1] + PERIOD * (1.0 - y[0]) if held == wanted else d[1]]


SAMPLED = {"every": PERIOD, "on_event": controller, **TIGHT}


@pytest.mark.few(5)
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Taylor", "Rodas5P", "Radau", "RK4", "ode45"])
@pytest.mark.parametrize("t_eval", [None, np.linspace(0.0, 4.0, 9)])
def test_each_trajectory_is_the_single_solve(method, t_eval):
    given = {**SAMPLED, "discrete": [0.0, 0.0], "t_eval": t_eval}
    if method == "RK4":
        given |= {"step": 0.01, "rtol": None, "atol": None}
        given = {name: each for name, each in given.items() if name not in TIGHT}
    run = solve_ensemble(plant, (0.0, 4.0), [0.0, 0.0], (GAINS,), method, **given)
    assert run.success.all() and (run.width > 1) == (method not in ("Radau", "RK4"))
    assert run.y0.shape == (1, 2) and run.y_end.shape == (19, 2) and run.discrete_end.shape[1] == 2
    for i, gain in enumerate(GAINS):
        one = solve_ivp(plant, (0.0, 4.0), [0.0, 0.0], method, args=(gain,), **given)
        found, last = run[i], slice(-1, None) if t_eval is None else slice(None)
        assert np.allclose(found.y, one.y[:, last], atol=1e-8)
        assert np.allclose(found.discrete, one.discrete[:, last], atol=1e-8)
        assert np.array_equal(found.t_events[0], one.t_events[0])
        assert np.allclose(found.discrete_events[0], one.discrete_events[0], atol=1e-8)
        assert np.allclose(found.y_events[0], one.y_events[0], atol=1e-8)
    assert np.abs(run.discrete[:, 0]).max() == LIMIT


@pytest.mark.parametrize("simd", ["auto", False])
def test_starts_and_times_of_each_trajectory(simd):
    """Doses that are remembered: the amount of each trajectory, at its times."""
    amounts = np.linspace(1.0, 2.0, 11)[:, None]
    times = [np.array([0.5, 1.0 + 0.1 * i]) for i in range(11)]
    run = solve_ensemble(
        lambda t, y, d: [-0.3 * y[0]], (0.0, 3.0), np.ones((11, 1)), events=at(times),
        discrete=amounts, on_event=lambda t, y, d: ([y[0] + d[0]], [0.5 * d[0]]), simd=simd,
        **TIGHT,
    )  # fmt: skip
    for i, (amount,) in enumerate(amounts):
        given = np.array([1.0, amount, 0.5 * amount]), np.array([0.0, *times[i]])
        exact = (given[0] * np.exp(-0.3 * (3.0 - given[1]))).sum()
        assert run.y_end[i, 0] == pytest.approx(exact, abs=1e-8)
        assert run.discrete[i] == pytest.approx([0.25 * amount])
        assert run.discrete_events[0][i][:, 0] == pytest.approx([amount, 0.5 * amount])


def test_modes_in_lanes():
    """Thermostats whose heaters differ, in vectors and alone."""
    power = np.linspace(3.0, 6.0, 13)
    given = {"discrete": [0.0], **SWITCH, **TIGHT}
    lanes = solve_ensemble(heated, (0.0, 30.0), [19.5], (power,), **given)
    alone = solve_ensemble(heated, (0.0, 30.0), [19.5], (power,), simd=False, **given)
    assert lanes.width > 1 and alone.width == 1
    assert np.array_equal(lanes.discrete_end, alone.discrete_end)
    assert np.allclose(lanes.y_end, alone.y_end, atol=1e-9)
    for mine, others in zip(lanes.t_events[0], alone.t_events[0], strict=True):
        assert np.allclose(mine, others, atol=1e-9)


def test_reductions_clients_and_tables():
    xarray = pytest.importorskip("xarray")
    given = {**SAMPLED, "events": [every(PERIOD)], "discrete": np.zeros((19, 2))}
    del given["every"]
    run = solve_ensemble(plant, (0.0, 2.0), [0.0, 0.0], (GAINS,), reduce="final", **given)
    assert np.array_equal(run.reduced["final"], run.y_end) and run.y_end.shape == (19, 2)
    table = run.to_xarray()
    assert isinstance(table, xarray.Dataset) and table.discrete.shape == (19, 2)
    mode = {"discrete": [0.0], **SWITCH, **TIGHT}
    here = solve_ensemble(heated, (0.0, 9.0), [19.5], (GAINS,), **mode)
    with ThreadPoolExecutor(2) as client:
        there = solve_ensemble(heated, (0.0, 9.0), [19.5], (GAINS,), client=client, **mode)
    assert np.array_equal(here.discrete_end, there.discrete_end)
    assert np.array_equal(here.y_end, there.y_end)


def test_memories_of_python_functions_in_ensembles():
    def noted(t, y, d):
        float(repr(float(t)))  # no code is compiled from this
        return y, [d[0] + 1.0]

    with pytest.warns(UserWarning, match="noted"):
        run = solve_ensemble(
            lambda t, y, d: [d[0]], (0.0, 2.5), np.zeros((3, 1)), every=1.0, on_event=noted,
            discrete=[[0.0], [1.0], [2.0]], **TIGHT,
        )  # fmt: skip
    assert np.allclose(run.y_end[:, 0], [4.5, 7.0, 9.5])
    assert np.array_equal(run.discrete[:, 0], [3.0, 4.0, 5.0])


def test_a_start_that_is_not_finite_fails_alone():
    starts = [[np.nan, 0.0], [0.0, 0.0]]
    run = solve_ensemble(plant, (0.0, 1.0), starts, (1.0,), discrete=[0.0, 0.0], **SAMPLED)
    assert run.status.tolist() == [-1, 0] and "component 0" in run.message(0)


SENTENCES = [
    ({"discrete": np.zeros((5, 2))}, ValueError, "`y0` has 4, `discrete` has 5"),
    ({"discrete": np.zeros((4, 3, 2))}, ValueError, "`discrete` must be"),
    ({"discrete": [[1.0, 2.0], [3.0]]}, ValueError, "rows of one length"),
    ({"discrete": [[0.0, np.nan]] * 4}, ValueError, "`discrete` must be finite|finite"),
    ({"discrete": []}, ValueError, "one number at least"),
    ({"on_event": None}, ValueError, "`discrete` never changes"),
    ({"on_event": [None]}, ValueError, "`discrete` never changes"),
    ({"method": "VelocityVerlet", "step": 0.1}, ValueError, "takes no `discrete`"),
    ({"store": "anywhere"}, ValueError, "`store` has states alone"),
    ({"reduce": "max"}, ValueError, "does not see the jumps"),
]


@pytest.mark.parametrize(("given", "error", "words"), SENTENCES)
def test_hostile_discrete_states_are_answered_by_sentences(given, error, words):
    usual = {"discrete": [0.0, 0.0], "every": 0.1, "on_event": lambda t, y, d: (y, d)}
    with pytest.raises(error, match=words):
        solve_ensemble(
            lambda t, y, d: [y[1], d[0]], (0.0, 1.0), np.zeros((4, 2)), **{**usual, **given}
        )


def test_an_action_without_a_pair_fails_in_words():
    run = solve_ensemble(
        lambda t, y, d: [d[0]], (0.0, 1.0), [0.0], discrete=[0.0], at=[0.5],
        on_event=lambda t, y, d: y,
    )  # fmt: skip
    assert run.status.tolist() == [-1]
    assert "`on_event` must return (y, d), 1 and 1 numbers" in run.message(0)


def test_events_that_count_in_each_trajectory():
    """The pendulum's passages upwards: its event has attributes, which the longer state keeps."""
    passed = marked(lambda t, y, d, w: y[0], direction=1, terminal=3)
    frequencies = np.linspace(1.0, 3.0, 7)
    run = solve_ensemble(
        lambda t, y, d, w: [y[1], -w * w * y[0]], (0.0, 40.0), [1.0, 0.0], (frequencies,),
        events=passed, on_event=lambda t, y, d, w: (y, [d[0] + 1.0]), discrete=[0.0], **TIGHT,
    )  # fmt: skip
    assert (run.status == 1).all() and (run.discrete[:, 0] == 2.0).all()
    assert np.allclose(run.t_end, (1.5 + 4.0) * np.pi / frequencies, atol=1e-7)
