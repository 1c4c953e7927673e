"""The phase of a study is that of the motion, large or small."""

import numpy as np

import fastdyn
from fastdyn.systems import satellite


def test_the_phase_of_a_study_is_that_of_counted_turns():
    """RK45 at 1e-6 loses energy: after 700 orbits it is more than a revolution ahead."""
    system, turns = satellite(V=1.2), 700
    given = {"rtol": 1e-6, "atol": 1e-9}
    study = fastdyn.energy_drift(system, "RK45", periods=turns, **given)
    end = turns * system.period
    run = system.solve((0, end), t_eval=[end], events="periapsis", **given)
    passages = run.t_events[0]
    ahead = (len(passages) - 1) * system.period - passages[-1]
    turn = passages[-1] - passages[-2]
    assert ahead > 1.5 * system.period
    assert abs(study.phase[-1] - ahead) < abs(turn - system.period) + 0.01 * ahead
    assert np.abs(np.diff(study.phase)).max() < 0.1 * system.period


def test_a_small_phase_is_as_exact_as_it_was():
    system = satellite(V=1.2)
    study = fastdyn.energy_drift(system, "Gauss16", periods=10, steps_per_period=60, samples=10)
    exact = system.exact(study.t)
    rates = np.array([system.rhs(0.0, w, *system.args) for w in exact.T]).T
    linear = ((study.y - exact) * rates).sum(axis=0) / (rates * rates).sum(axis=0)
    assert np.abs(study.phase - linear).max() < 1e-12
