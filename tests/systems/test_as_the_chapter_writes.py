"""What the chapter writes is taken as it stands: driver(t), a release at an angle."""

import math
import pickle

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.derive.pages import page
from fastdyn.systems.vehicle import drunk

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}


def chapters(t):
    """The driver of the chapter's script."""
    return 0.1 + 0.2 * math.sin(t), 0.2 * math.cos(t), 0.2


@pytest.mark.parametrize("derived", [False, True])
def test_a_driver_may_know_the_time_alone(derived):
    vehicle = page("vehicle").derive().system if derived else systems.vehicle
    run, known = (vehicle(driver=one).solve((0, 5), **TIGHT) for one in (chapters, drunk))
    assert np.array_equal(run.y, known.y)
    again = vehicle(driver=run.system.driver)
    assert again == run.system and hash(again.driver) == hash(run.system.driver)
    with pytest.raises(TypeError, match=r"must be a function of \(t, w\), or of t"):
        vehicle(driver=lambda t, w, u: (0, 0, 0))


def test_such_a_vehicle_is_sent_to_another_process():
    assert pickle.loads(pickle.dumps(systems.vehicle(driver=chapters))).driver(0.5, ()) == chapters(
        0.5
    )
    assert "driver=chapters" in str(systems.vehicle(driver=chapters))


STARTS = [
    (1.0, 0.0), (-1.0, 0.0), (2.9, 0.0), (-2.0, 1.0), (1.0, -2.0), (1.0, 7.0), (-1.0, 9.0),
    (3.0, -8.0), (-0.3, 0.1), (0.5, 2.0 * math.sqrt(9.81) * math.cos(0.25)), (1e-9, 0.0),
    (2.0 * math.pi - 0.1, 0.5),
]  # fmt: skip


@pytest.mark.parametrize(("theta0", "V0"), STARTS)
def test_a_pendulum_released_at_an_angle_has_its_exact_solution(theta0, V0):
    system = systems.pendulum(theta0=theta0, V0=V0)
    assert system.exact(0.0) == pytest.approx([theta0, V0], abs=1e-12)
    run = system.solve((0, 5), **TIGHT)
    growth = math.exp(5.0 * system.natural_frequency)  # of errors beside the separatrix
    allowed = 10.0 * TIGHT["rtol"] * (growth if abs(system.modulus - 1.0) < 0.02 else 50.0)
    assert np.abs(run.error()).max() <= allowed
    if system.regime == "swinging" and V0 == 0.0:
        assert system.largest_angle == pytest.approx(abs(theta0), rel=1e-12)
        assert system.time_to(0.0) == pytest.approx(system.period / 4, rel=1e-12)


def test_a_release_from_rest_returns_after_its_period():
    system = systems.pendulum(theta0="60 deg", V0=0.0)
    turns = system.solve((0, 10), events="turning", **TIGHT).t_events[0]
    assert np.diff(turns) == pytest.approx(system.period / 2, rel=1e-8)
    small = systems.pendulum(theta0=0.01, V0=0.0)
    t = np.linspace(0, 5, 50)
    assert small.small_angle(t) == pytest.approx(small.exact(t), abs=1e-5)


def test_times_of_first_passage_are_those_of_the_run():
    for theta0, V0, angle in ((1.0, 2.0, 1.2), (1.0, 2.0, 0.5), (1.0, -2.0, 0.5), (-1.0, 7.0, 2.0)):
        system = systems.pendulum(theta0=theta0, V0=V0)

        def passes(t, w, *args, angle=angle):
            return w[0] - angle

        first = system.solve((0, 5), events=passes, **TIGHT).t_events[0][0]
        assert system.time_to(angle) == pytest.approx(first, rel=1e-8)


def test_slack_is_where_the_tension_ends():
    for theta0, V0 in ((1.0, 4.9), (-1.0, 5.5), (0.5, -5.8)):
        system = systems.pendulum(theta0=theta0, V0=V0)
        run = system.solve((0, 5), events="slack", **TIGHT)
        assert run.status == 1
        assert system.slack_time == pytest.approx(run.t[-1], rel=1e-8)
    assert math.isnan(systems.pendulum(theta0=1.0, V0=0.0).slack_time)
    assert systems.pendulum(theta0=2.5, V0=0.0).slack_time == 0.0
