"""Implicit steps with all stages on vectors: the same bits as one stage after the other."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.compile import memory
from fastdyn.specialise import scalar


def elementary(t, w):
    x, y, u, v = w
    r = np.hypot(x, 1.0)
    pull = math.exp(-y * y) * math.tanh(x) + np.arctan2(x, 2.0) / r**3
    return [u, v, -pull, -y * (1.0 + x * x) ** -2 + 0.1 * np.sin(t) * abs(y) ** 1.5]


def branching(t, w):
    return [w[1], -w[0] if w[0] > 0 else -2.0 * w[0]]


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["Gauss4", "Gauss16", "GaussNystrom8", "EnergyConserving4"])
@pytest.mark.parametrize("fun", [elementary, branching])
def test_both_tiers_give_the_same_bits(method, fun, monkeypatch, tmp_path):
    y0 = [0.3, 0.2, 0.1, 0.5] if fun is elementary else [1.0, 0.3]
    one = solve_ivp(fun, (0, 20), y0, method, step=0.1, compile="shared")
    taken, build = [], scalar._stages
    memory.forget()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))  # nothing is there

    def noted(*given):
        kernel = build(*given)
        taken.append(kernel)
        return kernel

    monkeypatch.setattr(scalar, "_stages", noted)
    all_at_once = solve_ivp(fun, (0, 20), y0, method, step=0.1, compile="inlined")
    assert np.array_equal(one.y, all_at_once.y) and one.nfev == all_at_once.nfev
    assert len(taken) == 1
