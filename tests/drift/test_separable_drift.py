"""Energy over long runs of H = T(p) + V(q)."""

import numpy as np
import pytest

import fastdyn
from fastdyn.kernels.methods import METHODS
from support.hamiltonians import GIVEN, START, balance, born, eaten, energy, force, pull, velocity

EPS = np.finfo(float).eps

SPLITTINGS = [name for name, m in METHODS.items() if m.separable]


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SPLITTINGS)
def test_energy_is_bounded_and_time_turns_back(name):
    study = fastdyn.energy_drift(
        (eaten, born), name, step=0.1, n_steps=50_000, y0=[0.3, 0.2], samples=300,
        invariants={"balance": balance},
    )  # fmt: skip
    assert study.drifts["balance"].growth.verdict in ("bounded", "random walk")
    assert study.drifts["balance"].largest < 1e-2
    there = fastdyn.solve.solve_separable(eaten, born, (0, 50), [0.3], [0.2], name, step=0.1)
    q, p = there.y[:, -1:]
    back = fastdyn.solve.solve_separable(eaten, born, (50, 0), q, p, name, step=0.1)
    assert np.abs(back.y[:, -1] - [0.3, 0.2]).max() < 1e-12


def test_compensated_sums_are_carried_here_too():
    """Seven million kicks and drifts whose method error is below rounding; without, 3e-13."""
    study = fastdyn.energy_drift(
        (velocity, force), "SofroniouSpaletta10", step=0.05, n_steps=200_000, y0=[1.2, 0.4],
        invariants={"energy": energy}, **GIVEN,
    )  # fmt: skip
    assert study.drifts["energy"].largest < 60 * EPS


def test_drifts_are_compared_and_kept(tmp_path):
    given = {
        "periods": 20, "period": 5.0, "y0": [1.2, 0.4], "invariants": {"energy": energy},
        "evaluations": 400, "samples": 64, "checkpoint": tmp_path / "run.npz", **GIVEN,
    }  # fmt: skip
    methods = ["VelocityVerlet", "BlanesMoanPRK4", "Gauss8"]
    found = fastdyn.drift.compare_drift((velocity, force), methods, **given)
    assert [s.nfev / 20 for s in found.values()] == pytest.approx([400] * 3, rel=0.2)
    assert {p.name for p in tmp_path.iterdir()} == {f"run-{name}.npz" for name in methods}
    again = fastdyn.drift.compare_drift((velocity, force), methods, **given)
    assert all(np.array_equal(again[name].y, found[name].y) for name in methods)
    deeper = {**given, "checkpoint": tmp_path / "deeper.npz"}
    fastdyn.drift.compare_drift((velocity, pull(1.0)), methods[:1], **deeper)
    with pytest.raises(ValueError, match="differs: functions"):
        fastdyn.drift.compare_drift((velocity, pull(2.0)), methods[:1], **deeper)
    other = fastdyn.solve.solve_separable(
        velocity, force, (0, 9), *START, step=0.1, checkpoint=tmp_path / "solve.npz", **GIVEN
    )
    assert other.success
    with pytest.raises(ValueError, match="differs: functions"):
        fastdyn.solve.solve_separable(
            velocity, lambda t, q, c: [-q[0]], (0, 9), *START, step=0.1,
            checkpoint=tmp_path / "solve.npz", **GIVEN,
        )  # fmt: skip
