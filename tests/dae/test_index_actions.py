"""`on_event`, schedules, `discrete`, `callback`, `breakpoints` with index reduction."""

import functools

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp
from support.mechanisms import from_angle, pendulum
from tests.support.impacts import marked

reduced = functools.partial(solve_dae, method="DOP853")
ARGS = (1.0, 9.81)
TIGHT = {"rtol": 1e-10, "atol": 1e-10}


def swing(t, y, length, g):
    return [y[1], -g / length * np.sin(y[0])]


def wall(t, y, length, g):
    return y[0]  # x, or the angle


def bounced(t, y, length, g):
    return [y[0], y[1], -0.8 * y[2], -0.8 * y[3], y[4]]


@pytest.mark.parametrize("method", [None, "DOP853", "Taylor", "Radau"])
def test_a_pendulum_of_its_length_alone_bounces_off_a_wall(method):
    """The wall at its lowest point, beside the pendulum of its angle."""
    tight = {"rtol": 1e-8, "atol": 1e-8} if method == "Radau" else TIGHT
    found = solve_dae(
        pendulum, (0, 3), from_angle(1.2, 0.0, *ARGS), args=ARGS, method=method,
        events=marked(wall, direction=-1), on_event=bounced, dense_output=True, **tight,
    )  # fmt: skip
    angle = solve_ivp(
        swing, (0, 3), [1.2, 0.0], "DOP853", args=ARGS, events=marked(wall, direction=-1),
        on_event=lambda t, y, length, g: [y[0], -0.8 * y[1]], dense_output=True,
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    assert found.success and found.index == 3 and len(found.t_events[0]) >= 3
    assert found.t_events[0] == pytest.approx(angle.t_events[0], abs=1e-6)
    times = np.linspace(0, 3, 200)
    exact = from_angle(*angle.sol(times), *ARGS)
    assert np.abs(found.sol(times) - exact)[:4].max() < 1e-5
    x, z, u, v, force = found.y
    assert np.abs(np.hypot(x, z) - 1).max() < 1e-13 and np.abs(x * u + z * v).max() < 1e-12
    (twice,) = np.nonzero(np.diff(found.t) == 0)
    assert found.y[2, twice + 1] == pytest.approx(-0.8 * found.y[2, twice], rel=1e-9)
    speed = u**2 + v**2
    assert force == pytest.approx(speed - 9.81 * z, rel=1e-6)  # of both sides, from the equations


def test_the_state_behind_an_action_is_one_of_the_equations():
    """Without `given` an action must satisfy the constraints; with numbers, the others move."""

    def struck(t, y, length, g):
        return [y[0], y[1], 3.0, 5.0, 0.0]

    given = {
        "args": ARGS, "events": marked(lambda t, y, length, g: t - 0.1), "on_event": struck,
        "F": pendulum, "t_span": (0, 0.3), "y0": [0.6, -0.8, 0.0, 0.0, 0.0],
    }  # fmt: skip
    said = "`on_event` returned at t = 0.1 is none of the equations: .* component [23] would move"
    with pytest.raises(ValueError, match=said):
        solve_dae(**given)
    found = solve_dae(**given, dense_output=True, given=[2])
    (i,) = np.flatnonzero(np.diff(found.t) == 0)
    x, z, u, v, _ = found.y[:, i + 1]
    assert u == 3.0 and x * u + z * v == pytest.approx(0.0, abs=1e-13)
    nearest = solve_dae(**given, given=[])
    x, z, u, v, _ = nearest.y[:, i + 1]
    along = (3.0 * -z + 5.0 * x) / (x * x + z * z)
    assert [u, v] == pytest.approx([-z * along, x * along])


def test_an_action_that_returns_nothing_usable():
    given = {"args": ARGS, "events": marked(lambda t, y, *args: t - 0.1)}
    start = [0.6, -0.8, 0.0, 0.0, 0.0]
    found = reduced(
        pendulum, (0, 1), start, on_event=lambda t, y, *args: [y[0], np.nan, 0, 0, 0], **given
    )
    assert found.status == -1 and "returned nan or inf at t = 0.1 (component 1)" in found.message
    with pytest.raises(ValueError, match="`on_event` returned 2 values"):
        reduced(pendulum, (0, 1), start, on_event=lambda t, y, *args: [0.0, 0.0], **given)
    with pytest.raises(ZeroDivisionError):
        reduced(pendulum, (0, 1), start, on_event=lambda t, y, *args: [1 / 0.0], **given)


def test_kicks_on_a_schedule_backwards_and_forwards():
    def kick(t, y, length, g):
        return [y[0], y[1], y[2] - 0.3 * y[1], y[3] + 0.3 * y[0], 0.0]

    def turned(t, y, length, g):
        return [y[0], y[1] + 0.3]

    given = {"args": ARGS, "at": [0.5, 1.25], "every": 0.8, "t_eval": [0.3, 1.0, 2.0], **TIGHT}
    found = reduced(pendulum, (0, 2), from_angle(0.7, 0.2, *ARGS), on_event=[kick, None], **given)
    angle = solve_ivp(swing, (0, 2), [0.7, 0.2], "DOP853", on_event=[turned, None], **given)
    assert found.y[:4] == pytest.approx(from_angle(*angle.y, *ARGS)[:4], abs=1e-7)
    assert [each.tolist() for each in found.t_events] == [[0.5, 1.25], [0.0, 0.8, 1.6]]
    back = reduced(
        pendulum, (2, 0), found.y[:, -1], args=ARGS, at=[0.5, 1.25],
        on_event=lambda t, y, *a: [y[0], y[1], y[2] + 0.3 * y[1], y[3] - 0.3 * y[0], 0.0], **TIGHT,
    )  # fmt: skip
    assert back.y[:4, -1] == pytest.approx(from_angle(0.7, 0.2, *ARGS)[:4], abs=1e-7)


def test_states_that_events_alone_change():
    """A pendulum whose drive a sampled controller holds: `discrete` at index 3 and 1."""

    def driven(t, y, yp, d, length, g):
        x, z, u, v, force = y
        return [
            yp[0] - u, yp[1] - v, yp[2] + force * x + d[0] * z, yp[3] + force * z + g - d[0] * x,
            x * x + z * z - length**2,
        ]  # fmt: skip

    def sample(t, y, d, length, g):
        return y, [-2.0 * y[0] - 0.5 * (y[2] * -y[1] + y[3] * y[0])]

    def turned(t, y, d, length, g):
        return [y[1], -g / length * np.sin(y[0]) + d[0]]

    def sampled(t, y, d, length, g):
        return y, [-2.0 * np.sin(y[0]) - 0.5 * y[1]]

    given = {"args": ARGS, "discrete": [0.0], "every": 0.1, **TIGHT}
    for method in (None, "Vern9"):
        found = solve_dae(
            driven, (0, 2), from_angle(0.7, 0.0, *ARGS), on_event=sample, method=method,
            t_eval=[0.55, 2.0], **given,
        )  # fmt: skip
        angle = solve_ivp(
            turned, (0, 2), [0.7, 0.0], "DOP853", on_event=sampled, t_eval=[0.55, 2.0], **given
        )
        assert found.y.shape == (5, 2) and found.discrete.shape == (1, 2) and found.index == 3
        assert found.y[:4] == pytest.approx(from_angle(*angle.y, *ARGS)[:4], abs=1e-7)
        assert found.discrete == pytest.approx(angle.discrete, abs=1e-7)
        assert found.differentiated.tolist() == [1, 1, 0, 0, 2]
        assert {k for _, states in found.states for k in states} <= {0, 1, 2, 3}


@pytest.mark.parametrize("method", [None, "DOP853"])
def test_a_callback_sees_all_components(method):
    seen = []

    def look(solver):
        seen.append((solver.t, *solver.y))
        middle = (solver.t + solver.t_old) / 2
        x, z = solver.interpolate(middle)[:2]
        assert solver.n == 5 and solver.y.shape == (5,)
        assert np.hypot(x, z) == pytest.approx(1.0, abs=1e-6)
        return solver.t > 0.5

    found = solve_dae(
        pendulum, (0, 2), from_angle(1.0, 0.0, *ARGS), args=ARGS, callback=look, method=method
    )
    assert found.status == 1 and 0.5 < found.t[-1] < 2.0
    assert np.array_equal(np.array(seen)[:, 0], found.t[1:])
    assert np.array(seen)[:, 1:] == pytest.approx(found.y[:, 1:].T, rel=1e-9, abs=1e-12)


def test_breakpoints_of_forces_at_index_3():
    def pushed(t, y, yp):
        x, z, u, v, force = y
        push = 5.0 if t < 0.5 else -3.0
        return [
            yp[0] - u, yp[1] - v, yp[2] + force * x - push, yp[3] + force * z + 9.81,
            x * x + z * z - 1,
        ]  # fmt: skip

    def turned(t, y):
        return [y[1], -9.81 * np.sin(y[0]) + (5.0 if t < 0.5 else -3.0) * np.cos(y[0])]

    given = {"breakpoints": [0.5], **TIGHT}
    found = reduced(pushed, (0, 1), from_angle(0.3, 0.0, *ARGS), **given)
    angle = solve_ivp(turned, (0, 1), [0.3, 0.0], "DOP853", **given)
    assert found.y[:4, -1] == pytest.approx(from_angle(*angle.y[:, -1], *ARGS)[:4], abs=1e-8)


def test_taylor_finds_events_of_states_and_refuses_events_of_forces():
    """The sentence names the force, and no kink that the user did not write."""

    def crossing(t, y, *args):
        return y[0] - 0.3

    def taut(t, y, *args):
        return y[4] - 12.0

    given = {"args": ARGS, **TIGHT}
    start = from_angle(1.0, 0.0, *ARGS)
    series, steps = (
        solve_dae(pendulum, (0, 2), start, method=method, events=crossing, **given)
        for method in ("Taylor", "Vern9")
    )
    assert len(series.t_events[0]) >= 2
    assert series.t_events[0] == pytest.approx(steps.t_events[0], abs=1e-8)
    assert series.y_events[0][:, 0] == pytest.approx(0.3)
    with pytest.raises(ValueError, match="component 4 of y, which an event uses, has none"):
        solve_dae(pendulum, (0, 2), start, method="Taylor", events=[crossing, taut], **given)
    forces = reduced(pendulum, (0, 2), start, events=[crossing, taut], **given)
    assert len(forces.t_events[1]) and forces.y_events[1][:, 4] == pytest.approx(12.0)


@pytest.mark.filterwarnings("ignore:.*forced")
def test_an_event_that_an_action_changes_is_followed():
    """The event asks for another component once the action has run."""
    asked = ["x"]

    def event(t, y, *args):
        return y[0] - 0.3 if asked[0] == "x" else y[1] + 0.9

    def act(t, y, *args):
        asked[0] = "z"
        return y

    found = reduced(
        pendulum, (0, 1), from_angle(1.0, 0.0, *ARGS), args=ARGS, events=event, on_event=act,
        **TIGHT,
    )  # fmt: skip
    assert found.y_events[0][0, 0] == pytest.approx(0.3)
    assert len(found.t_events[0]) > 1 and found.y_events[0][1:, 1] == pytest.approx(-0.9)

    def forced(t, y, *args):
        return y[0] - 0.3 if asked[0] == "x" else y[4] - 9.0

    asked[0] = "x"
    with pytest.raises(ValueError, match="uses component 4 of y since another function has"):
        reduced(
            pendulum, (0, 1), from_angle(1.0, 0.0, *ARGS), args=ARGS, events=forced, on_event=act
        )
