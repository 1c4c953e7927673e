"""solve_dde_ensemble: each trajectory has the bits of solve_dde, on any number of threads."""

import numpy as np
import pytest

from fastdyn import CompileWarning, solve_dde, solve_dde_ensemble
from fastdyn.ensemble import Shared
from support.delayed import late

OPTIONS = {"rtol": 1e-7, "atol": 1e-8, "compile": "shared"}
TAUS = np.linspace(0.2, 1.2, 7)


def moving(t, gain, tau):
    return [np.cos(gain * t), tau * t]


def passes(t, y, past, gain, tau):
    return y[0] - past(t - tau)[0] - 0.3


def alone(i, history, more):
    args = 1.1, float(TAUS[i])
    return solve_dde(late, (0, 8), history, args=args, **more, **OPTIONS)


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("history", [[1.0, 0.0], moving], ids=["constant", "function"])
@pytest.mark.parametrize(
    "more",
    [{}, {"t_eval": [4.0, 7.0]}, {"events": passes}, {"method": "Rodas5P"}],
    ids=["ends", "outputs", "events", "stiff"],
)
def test_trajectories_equal_single_solves(more, history, threads):
    found = solve_dde_ensemble(
        late, (0, 8), history, (1.1, TAUS), threads=threads, **more, **OPTIONS
    )
    assert found.success.all() and len(found) == len(TAUS)
    for i in (0, 3, 6):
        wanted = alone(i, history, more)
        np.testing.assert_array_equal(
            found[i].y, wanted.y if more.get("t_eval") else wanted.y[:, -1:]
        )
        assert (found[i].nfev, found[i].n_rejected) == (wanted.nfev, wanted.n_rejected)
        assert found[i].delays.tolist() == [TAUS[i]]
        np.testing.assert_array_equal(found[i].jumps, wanted.jumps)
        assert found.y0[i].tolist() == [1.0, 0.0]
        if more.get("events"):
            np.testing.assert_array_equal(found.t_events[0][i], wanted.t_events[0])
            np.testing.assert_array_equal(found.y_events[0][i], wanted.y_events[0])
        whole = alone(i, history, {k: v for k, v in more.items() if k == "method"})
        assert found.t_end[i] == 8.0
        np.testing.assert_array_equal(found.y_end[i], whole.y[:, -1])


def test_a_history_for_each_trajectory():
    starts = np.array([[1.0, 0.0], [0.5, 0.2], [0.1, 3.0]])
    histories = [lambda t: [1.0, t], lambda t: [np.cos(t), 0.0], lambda t: [np.exp(t), 1.0]]
    for given in (starts, histories):
        found = solve_dde_ensemble(late, (0, 5), given, (1.1, TAUS[:3]), **OPTIONS)
        for i in range(3):
            wanted = solve_dde(late, (0, 5), given[i], args=(1.1, float(TAUS[i])), **OPTIONS)
            np.testing.assert_array_equal(found.y[i], wanted.y[:, -1])
    earlier = [
        solve_dde(late, (0, 5), start, args=(1.1, 0.5), dense_output=True, **OPTIONS)
        for start in starts
    ]
    found = solve_dde_ensemble(late, (5, 9), earlier, (1.1, 0.5), **OPTIONS)
    wanted = solve_dde(late, (5, 9), earlier[2], args=(1.1, 0.5), **OPTIONS)
    np.testing.assert_array_equal(found.y[2], wanted.y[:, -1])


def test_a_trajectory_fails_alone_with_its_sentence():
    taus = np.array([0.5, -0.2, 0.7])
    found = solve_dde_ensemble(late, (0, 5), [1.0, 0.0], (1.1, taus), **OPTIONS)
    assert found.status.tolist() == [0, -1, 0]
    assert "a delay is -0.2" in found.message(1) and np.isnan(found.y[1]).all()

    def grows(t, y, past, rate):
        return [rate * y[0] ** 2 + past(t - 1.0)[0]]

    found = solve_dde_ensemble(grows, (0, 2), [1.0], ([-1.0, 1.0],), **OPTIONS)
    assert found.status.tolist() == [0, -1] and 0.0 < found.t_end[1] < 1.0
    assert found.message(1) == solve_dde(grows, (0, 2), [1.0], args=(1.0,), **OPTIONS).message
    with pytest.raises(ValueError, match=r"a delay is -1"):
        solve_dde_ensemble(late, (0, 5), [1.0, 0.0], (1.1, [-1.0, -2.0]), **OPTIONS)


def test_a_terminal_event_ends_a_trajectory():
    def low(t, y, past, gain, tau):
        return y[0]

    low.terminal = True
    found = solve_dde_ensemble(
        late, (0, 8), [1.0, 0.5], (1.1, TAUS), events=low, t_eval=[0.5, 8.0], **OPTIONS
    )
    assert (found.status == 1).all() and np.isnan(found.y[:, :, 1]).all()
    assert [times.tolist() for times in found.t_events[0]] == found.t_end[:, None].tolist()
    assert np.abs(found.y_end[:, 0]).max() < 1e-12


def test_tables_and_labels():
    found = solve_dde_ensemble(late, (0, 5), [1.0, 0.0], (1.1, TAUS), **OPTIONS)
    assert [label.name for label in found.argument_labels] == ["gain", "tau"]
    assert "tau" in found.to_pandas().columns
    weights = np.array([0.5, 1.0])
    found = solve_dde_ensemble(
        lambda t, y, past, w, tau: -w * past(t - tau), (0, 3), [1.0, 2.0],
        (Shared(weights), TAUS), **OPTIONS,
    )  # fmt: skip
    assert found.y.shape == (7, 2)


def test_functions_in_python_run_on_one_thread():
    def hidden(t, y, past, tau):
        return [float(str(-past(t - tau)[0]))]

    with pytest.warns(CompileWarning):
        found = solve_dde_ensemble(
            hidden, (0, 2), [1.0], ([0.5, 1.0],), delays=[0.5, 1.0], threads=2, **OPTIONS
        )
    wanted = solve_dde_ensemble(
        lambda t, y, past, tau: -past(t - tau), (0, 2), [1.0], ([0.5, 1.0],), delays=[0.5, 1.0],
        **OPTIONS,
    )  # fmt: skip
    np.testing.assert_allclose(found.y, wanted.y, rtol=0, atol=1e-14)
