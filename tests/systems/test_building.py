"""Claims about the building, and about ground that is sampled."""

import math

import numpy as np
import pytest
import scipy.integrate

from fastdyn.course.lessons.building import printed
from fastdyn.systems import (
    building,
)

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def test_without_an_earthquake_the_building_stands_still_and_the_printed_one_does_not():
    still = building(d=0.0)
    run = still.solve(**TIGHT)
    assert np.ptp(run.y[:2], axis=1).max() <= 1e-12 + 1e-10 * 20.0
    wrong = scipy.integrate.solve_ivp(
        printed, (0, 20), still.initial_state(), args=still.args[:6], **TIGHT
    )
    assert np.ptp(wrong.y[0]) > 0.05


def test_building_shakes_most_at_its_frequencies():
    t = np.linspace(0.0, 20.0, 4001)
    travel = {w: np.ptp(building(omega=w).exact(t)[1]) for w in (4.0, 8.74, 15.0, 22.882, 29.0)}
    assert min(travel[8.74], travel[22.882]) > 5.0 * max(travel[4.0], travel[15.0], travel[29.0])


def test_accelerations_are_integrated_exactly():
    times = np.sort(np.random.default_rng(5).uniform(0.0, 5.0, 20))
    samples = np.random.default_rng(6).normal(size=20)
    house = building.sampled(times, accelerations=samples)
    run = scipy.integrate.solve_ivp(
        lambda t, y: [y[1], np.interp(t, times, samples)],
        (times[0], times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-11, atol=1e-13, max_step=0.01,
    )  # fmt: skip
    assert np.allclose(house.ground(times), run.y[0], rtol=0, atol=1e-8)
    outside = house.ground([times[0] - 1.0, times[-1] + 1.0])
    assert outside == pytest.approx([0.0, run.y[0, -1]], abs=1e-8)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"times": [0, 1], "displacements": [0, 1, 2]}, "as many samples"),
        ({"times": [1, 0], "displacements": [0, 1]}, "increase"),
        ({"times": [0, math.nan], "displacements": [0, 1]}, "finite"),
        ({"times": [0, 1], "displacements": [0, math.inf]}, "finite"),
        ({"times": [0, 1]}, "`displacements` or `accelerations`"),
        ({"times": [0, 1], "displacements": [0, 1], "accelerations": [0, 1]}, "or"),
    ],
)
def test_samples_that_make_no_motion_are_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        building.sampled(**arguments)
    with pytest.raises(ValueError, match="go together"):
        building(times=[0.0, 1.0])


def test_buildings_compare_and_hash():
    a, b = (building.sampled([0, 1, 2], displacements=[0, x, 0]) for x in (1, 2))
    assert a == building.sampled([0, 1, 2], displacements=[0, 1, 0]) != b
    assert len({a, b, building(), building()}) == 3
