"""Breakpoints, discrete states and callbacks of F(t, y, y') = 0 of index 1."""

import numpy as np
import pytest

from fastdyn import solve_dae
from tests.support.impacts import marked


def test_discrete_states_at_index_1():
    def tank(t, y, yp, d):
        level, outflow = y
        return [yp[0] - d[0] + outflow, outflow**2 - level]

    low, high = (marked(lambda t, y, d, at=at: y[0] - at, direction=way)
                 for at, way in ((0.25, -1), (1.0, 1)))  # fmt: skip
    acts = [lambda t, y, d: (y, [2.0]), lambda t, y, d: (y, [0.2])]
    for given in (None, "y", "yp", [0]):
        found = solve_dae(
            tank, (0, 20), [0.5, 0.5**0.5], [2.0 - 0.5**0.5, 0.0] if given == "yp" else None,
            discrete=[2.0], events=[low, high], on_event=acts, given=given, dense_output=True,
            rtol=1e-8, atol=1e-10,
        )  # fmt: skip
        assert found.success and found.y[0].min() > 0.2499 and found.y[0].max() < 1.0001
        assert set(np.round(found.discrete[0], 12)) == {0.2, 2.0}
        assert found.sol(1.0).shape == found.sol.derivative(1.0).shape == (2,)
        assert [len(each) for each in found.t_events] == [len(e) for e in found.discrete_events]


def test_a_callback_at_index_1():
    seen = []
    found = solve_dae(
        lambda t, y, yp: [yp[0] + y[1], y[1] - y[0]], (0, 1), [1.0, 1.0],
        callback=lambda solver: seen.append(solver.y) or solver.interpolate(solver.t).shape == (3,),
    )  # fmt: skip
    assert found.status == 0 and np.array_equal(np.array(seen), found.y[:, 1:].T)


def switched(t, y, yp):
    """A current that a resistance determines, which changes at t = 1."""
    charge, current = y
    resistance = 2.0 if t < 1.0 else 0.5
    return [yp[0] - current, resistance * current + charge - (3.0 if t >= 2.0 else 0.0)]


def charges(t):
    first = np.exp(-t / 2)
    at_one, at_two = np.exp(-0.5), np.exp(-2.5)
    second = at_one * np.exp(-2 * (t - 1))
    third = 3.0 + (at_two - 3.0) * np.exp(-2 * (t - 2))
    return np.where(t < 1, first, np.where(t < 2, second, third))


@pytest.mark.parametrize("on_event", [None, lambda t, y: y])
def test_breakpoints_at_index_1(on_event):
    given = {"rtol": 1e-9, "atol": 1e-11, "dense_output": True}
    events = None if on_event is None else marked(lambda t, y: y[0] - 0.9)
    found = solve_dae(
        switched, (0, 3), [1.0, -0.5], breakpoints=[1.0, 2.0], events=events, on_event=on_event,
        **given,
    )  # fmt: skip
    assert found.success and found.y[0] == pytest.approx(charges(found.t), abs=1e-7)
    ends = np.flatnonzero(np.isin(found.t, [1.0, 2.0]))
    assert found.t[ends].tolist() == [1.0, 1.0, 2.0, 2.0]
    q = charges(np.array([1.0, 2.0]))
    currents = [-q[0] / 2, -2 * q[0], -2 * q[1], 2 * (3 - q[1])]
    assert found.y[1, ends] == pytest.approx(currents, abs=1e-7)
    assert found.yp[0] == pytest.approx(found.y[1], abs=1e-6)
    times = np.linspace(0, 3, 50)
    assert found.sol(times)[0] == pytest.approx(charges(times), abs=1e-7)
    assert (found.t_events is None) == (on_event is None)
    if on_event is not None:
        assert len(found.t_events) == len(found.y_events) == len(found.yp_events) == 1
    back = solve_dae(
        switched, (3, 0), found.y[:, -1], breakpoints=[1.0, 2.0], rtol=1e-10, atol=1e-12
    )
    assert back.y[0] == pytest.approx(charges(back.t), abs=1e-5)
