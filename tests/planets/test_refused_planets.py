"""Where WisdomHolman may not be used, it says so."""

import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn.planets import Planets


def three(m=(1.0, 1e-3, 1e-3), x=1.5, v=None):
    q = [[0, 0, 0], [1, 0, 0], [x, 0, 0]]
    return Planets(m, q, v or [[0, 0, 0], [0, 1, 0], [0, 1 / np.sqrt(abs(x)), 0]])


@pytest.mark.parametrize(
    ("p", "said"),
    [
        (three((1.0, 2.0, 1e-3)), "the first; body 1 has the largest mass"),
        (three(x=1.15), "bodies 1 and 2 are closer than 3 mutual Hill radii at the start"),
        (three((1.0, 0.5, 1e-3), 2.3), "the perturbation of body 2 is .* more than 0.1"),
        (three((1.0, 1e-3, 0.4), 2.0), "the perturbation of body .* more than 0.1"),
    ],
)
def test_a_mass_that_does_not_dominate_is_refused(p, said):
    with pytest.raises(ValueError, match=said):
        p.solve((0, 1), step=0.1)


def told(message):
    """The time in the sentence about a meeting."""
    return float(message.split("t = ")[1].split(":")[0])


def test_a_meeting_ends_the_run_with_a_sentence():
    """Two planets on one orbit, one faster: they meet where a plain integration says."""
    a = np.array([1.0, 1.1])
    angle = np.array([0.0, 0.8])
    q = np.r_[[[0, 0, 0]], np.c_[a * np.cos(angle), a * np.sin(angle), 0 * a]]
    v = np.r_[[[0, 0, 0]], np.c_[-np.sin(angle), np.cos(angle), 0 * a] / np.sqrt(a)[:, None]]
    p = Planets([1.0, 1e-4, 1e-4], q, v)
    run = p.solve((0, 200), step=0.05, t_eval=np.linspace(0, 200, 201))
    assert run.status == -1 and not run.success
    assert "Bodies 1 and 2 come closer than 3 mutual Hill radii at t = " in run.message
    end = told(run.message)
    assert 2.0 < end < 40.0 and run.t[-1] <= end < run.t[-1] + 1.0
    places = run.y.reshape(2, 3, 3, -1)[0]
    hill = 1.1 * (2e-4 / 3) ** (1 / 3)
    assert np.linalg.norm(places[1] - places[2], axis=0).min() > 3 * hill * 0.95


def on_circles(masses, radii, angles, signs):
    a, angle = np.array(radii), np.array(angles)
    way = np.array(signs) * np.sqrt((1.0 + np.array(masses)) / a)
    c, s = np.cos(angle), np.sin(angle)
    q, v = np.c_[a * c, a * s, 0 * a], np.c_[-way * s, way * c, 0 * a]
    return Planets([1.0, *masses], np.r_[[[0, 0, 0]], q], np.r_[[[0, 0, 0]], v])


def earth_and_asteroid():
    """Three Hill radii, 0.03, are a tenth of the way of the Earth in a step."""
    e, f = 0.3, 2.5
    p = 1.3 * (1 - e * e)
    q = p / (1 + e * np.cos(f)) * np.array([np.cos(f), np.sin(f), 0])
    v = np.array([-np.sin(f), e + np.cos(f), 0]) / np.sqrt(p)
    earth = on_circles([3e-6], [1.0], [6.122078], [1])
    return Planets([1.0, 3e-6, 0.0], np.r_[earth.q0, [q]], np.r_[earth.v0, [v]])


def shares(p, t):
    """The distance of the planets along the exact motion, in three mutual Hill radii."""
    run = fastdyn.solve_ivp(
        p.rhs, (0, t[-1]), p.initial_state(), "Taylor", args=p.args, rtol=1e-13, atol=1e-16,
        t_eval=t,
    )  # fmt: skip
    star, a, b = run.y.reshape(2, 3, 3, -1)[0]
    r = np.maximum(np.linalg.norm(a - star, axis=0), np.linalg.norm(b - star, axis=0))
    hill = (p.masses[1:].sum() / 3.0) ** (1 / 3) * r
    return np.linalg.norm(a - b, axis=0) / (3.0 * hill)


BETWEEN_STEPS = [
    (earth_and_asteroid(), 2 * np.pi / 20),
    (on_circles([1e-5, 1e-5], [1.0, 1.001], [0.0, 2.8], [1, -1]), 0.3),
    (on_circles([1e-3, 1e-3], [1.0, 1.001], [0.0, 3.0], [1, -1]), 0.3),
]


@pytest.mark.parametrize(("p", "step"), BETWEEN_STEPS)
def test_a_meeting_between_two_steps_ends_the_run_before_it(p, step):
    """The sentence has the time at which the exact motion comes below the distance.

    The cubic of a step h is off by h^4/384 of its fourth derivative, 2^4 for the relative motion of
    two bodies in opposite directions; they approach at a speed of 1/4 at least.
    """
    t = np.linspace(0, 8, 80_001)
    enters = t[np.argmax(shares(p, t) < 1.0)]
    begins = np.floor(enters / step) * step
    run = p.solve((0, 20), step=step, t_eval=np.linspace(0, 20, 401))
    assert run.status == -1 and "Bodies 1 and 2 come closer than 3" in run.message
    met = told(run.message)
    assert met == pytest.approx(enters, rel=0, abs=4 * 16 * step**4 / 384 + 1e-4)
    # no output behind the meeting, nor in its step; those before are there
    assert begins - 0.05 < run.t[-1] < begins + 1e-9
    within = p.solve((0, 20), step=step, t_eval=[0.0, begins, begins + 0.9 * (enters - begins)])
    assert within.t.tolist() == [0.0, begins] and within.message == run.message
    # a run that ends before the meeting has none
    assert p.solve((0, begins + 0.9 * (enters - begins)), step=step).success
    assert not p.solve((0, enters + 0.1 * step), step=step).success
    # the same backwards in time
    q, v = run.y[:, 0].reshape(2, 3, 3)
    back = Planets(p.masses, q, -v).solve((0, -20), step=step)
    assert told(back.message) == pytest.approx(-met, rel=1e-9)


def test_planets_that_pass_outside_of_the_distance_are_followed():
    """Bodies on orbits apart by four mutual Hill radii, and a run over many passages."""
    apart = 1.0 + 4.0 * (2e-5 / 3) ** (1 / 3)
    p = on_circles([1e-5, 1e-5], [1.0, apart], [0.0, 2.8], [1, -1])
    t = np.linspace(0, 40, 40_001)
    assert 1.0 < shares(p, t).min() < 1.4
    assert p.solve((0, 40), step=0.3).success
    assert p.solve((0, -40), step=0.3).success


def test_steps_too_long_near_the_star_are_told():
    e = 0.9
    v = [[0, 0, 0], [0, np.sqrt((1 + e) / (1 - e)), 0], [0, 0.5, 0]]
    p = Planets([1.0, 1e-6, 1e-6], [[0, 0, 0], [1 - e, 0, 0], [4, 0, 0]], v)
    with pytest.warns(RuntimeWarning, match="steps were longer than an eighth of a revolution"):
        p.solve((0, 20), step=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        p.solve((0, 20), step=0.002)
        Planets(p.masses[:2], p.q0[:2], p.v0[:2]).solve((0, 20), step=0.1)  # two bodies: exact
