"""Drift studies of planets by WisdomHolman."""

import numpy as np
import pytest

import fastdyn
from fastdyn.drift import compare_drift
from fastdyn.drift.growth import LINEAR, WORSE
from fastdyn.planets import Planets, outer_planets
from fastdyn.systems import satellite


@pytest.mark.hunt
def test_a_study_of_planets():
    sun = outer_planets()
    study = fastdyn.energy_drift(sun, "WisdomHolman", steps_per_period=80, n_steps=50_000)
    assert study.method == "WisdomHolman" and study.n_steps == 50_000 and not study.message
    assert study.step == pytest.approx(sun.period / 80)
    assert set(study.drifts) == {"energy", "angular momentum"}
    for drift in study.drifts.values():
        assert drift.largest < 1e-12 and np.isfinite(drift.rounding)
    walk = study.drifts["angular momentum"]
    assert walk.largest < 16 * np.finfo(float).eps and walk.growth.verdict not in (LINEAR, WORSE)
    at = 37
    run = sun.solve((0, study.t[at]), step=study.step)
    assert (run.y[:, -1] == study.y[:, at]).all()


def test_the_corrector_of_a_study():
    sun = outer_planets()
    given = {"steps_per_period": 40, "n_steps": 2000, "every": 1}
    plain = fastdyn.energy_drift(sun, "WisdomHolman", corrector=0, **given)
    corrected = fastdyn.energy_drift(sun, "WisdomHolman", **given)
    assert plain.nfev == 2001 and corrected.nfev == 4002
    assert corrected.drifts["energy"].largest < 1e-4 * plain.drifts["energy"].largest
    again = fastdyn.energy_drift(sun, "WisdomHolman", corrector=17, **given)
    assert again.drifts["energy"].largest == corrected.drifts["energy"].largest


def test_methods_side_by_side():
    sun = outer_planets()
    both = compare_drift(sun, ["WisdomHolman", "BlanesMoan6"], evaluations=120, periods=40)
    ours, other = both["WisdomHolman"], both["BlanesMoan6"]
    assert ours.nfev == pytest.approx(120 * 40, rel=0.02)
    assert other.nfev == pytest.approx(120 * 40, rel=0.02)
    assert ours.drifts["energy"].largest < 1e-2 * other.drifts["energy"].largest
    both = compare_drift(
        sun, ["WisdomHolman", "BlanesMoan6"], steps_per_period=40, periods=40, corrector=0
    )
    assert both["WisdomHolman"].nfev == 40 * 40 + 1


def test_a_study_goes_on_from_its_checkpoint(tmp_path, monkeypatch):
    from fastdyn.drift import survey

    sun, given = outer_planets(), {"step": 0.1, "n_steps": 20_000, "rounding": False}
    whole = fastdyn.energy_drift(sun, "WisdomHolman", **given)
    took, times = survey.Survey.run, []

    def stopped(self, file, bar):
        chunk = type(self.steps).took

        def count(steps, seconds):
            times.append(seconds)
            if len(times) == 3:
                raise KeyboardInterrupt
            chunk(steps, seconds)

        monkeypatch.setattr(type(self.steps), "took", count)
        return took(self, file, bar)

    monkeypatch.setattr(survey.Survey, "run", stopped)
    file = tmp_path / "study.npz"
    with pytest.raises(KeyboardInterrupt, match="goes on from there"):
        fastdyn.energy_drift(sun, "WisdomHolman", checkpoint=file, **given)
    monkeypatch.undo()
    again = fastdyn.energy_drift(sun, "WisdomHolman", checkpoint=file, **given)
    assert (again.y == whole.y).all()
    assert again.drifts["energy"].rms == whole.drifts["energy"].rms
    with pytest.raises(ValueError, match="another run"):
        fastdyn.energy_drift(sun, "WisdomHolman", checkpoint=file, corrector=3, **given)


def test_what_a_study_refuses():
    with pytest.raises(ValueError, match="is for the motion of planets"):
        fastdyn.energy_drift(satellite(), "WisdomHolman", step=0.1, n_steps=10)
    sun = outer_planets()
    with pytest.raises(TypeError, match="takes no `rtol`: its steps are constant"):
        fastdyn.energy_drift(sun, "WisdomHolman", step=0.1, n_steps=10, rtol=1e-9)
    with pytest.raises(ValueError, match="give `step` or `steps_per_period`"):
        fastdyn.energy_drift(sun, "WisdomHolman", t_end=10)
    with pytest.raises(TypeError, match="`corrector` is for WisdomHolman"):
        fastdyn.energy_drift(sun, "BlanesMoan6", step=0.1, n_steps=10, corrector=17)
    with pytest.raises(ValueError, match="Planets"):
        fastdyn.solve_ivp(sun.rhs, (0, 1), sun.initial_state(), "WisdomHolman", args=sun.args)


def test_a_meeting_ends_a_study_with_its_sentence():
    a, angle = np.array([1.0, 1.1]), np.array([0.0, 0.8])
    q = np.r_[[[0, 0, 0]], np.c_[a * np.cos(angle), a * np.sin(angle), 0 * a]]
    v = np.r_[[[0, 0, 0]], np.c_[-np.sin(angle), np.cos(angle), 0 * a] / np.sqrt(a)[:, None]]
    p = Planets([1.0, 1e-4, 1e-4], q, v)
    study = fastdyn.energy_drift(p, "WisdomHolman", step=0.05, n_steps=4000)
    assert "Bodies 1 and 2 come closer than 3 mutual Hill radii" in study.message
    assert study.n_steps < 4000


def test_the_equations_of_planets_suit_other_methods():
    sun = outer_planets()
    study = fastdyn.energy_drift(sun, "GaussNystrom16", steps_per_period=12, periods=20)
    assert study.drifts["energy"].largest < 1e-13


def test_a_study_tells_of_steps_too_long():
    e = 0.9
    v = [[0, 0, 0], [0, np.sqrt((1 + e) / (1 - e)), 0], [0, 0.5, 0]]
    p = Planets([1.0, 1e-6, 1e-6], [[0, 0, 0], [1 - e, 0, 0], [4, 0, 0]], v)
    with pytest.warns(RuntimeWarning, match="longer than an eighth of a revolution"):
        fastdyn.energy_drift(p, "WisdomHolman", step=0.1, n_steps=200, rounding=False)
