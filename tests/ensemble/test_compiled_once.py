"""Numba compiles a kernel on vectors once; the text of each function is linked to the kernel."""

import math
import os

import numpy as np
import pytest

from fastdyn import solve_ensemble
from fastdyn.code_store import emit_object
from fastdyn.ensemble import Fold

STARTS = np.ones((9, 2)) * np.linspace(1, 2, 9)[:, None]


def decaying():
    """A rate that was never seen, and a function in which that is a constant."""
    rate = 1.0 + int.from_bytes(os.urandom(5), "big") / 2**40
    return rate, eval(f"lambda t, y: [-{rate!r} * y[0], y[0] * y[1]]")


def noted(made, compile):
    return lambda *given: made.append(given) or compile(*given)


@pytest.mark.few(2)
@pytest.mark.parametrize("folds", [(), (Fold(lambda last, t, y: t, name="end"),)])
@pytest.mark.parametrize("method", ["RK23", "Rodas5P"])
def test_numba_compiles_once_for_all_functions(method, folds, monkeypatch):
    made = []
    for name in ("of", "without_function"):
        monkeypatch.setattr(emit_object, name, noted(made, getattr(emit_object, name)))
    given = {"method": method, "reduce": folds or None, "rtol": 1e-6, "simd": True}
    solve_ensemble(decaying()[1], (0, 1), STARTS, **given)
    made.clear()
    rate, fun = decaying()
    found = solve_ensemble(fun, (0, 1), STARTS, **given)
    assert found.width > 1 and not made
    assert np.allclose(found.y_end[:, 0], STARTS[:, 0] * np.exp(-rate), rtol=1e-4)
    assert not folds or (found.reduced["end"] == 1.0).all()


def test_a_kernel_holds_for_any_number_of_parameters(monkeypatch):
    made = []
    compiled = emit_object.without_function
    monkeypatch.setattr(emit_object, "without_function", noted(made, compiled))

    def decays(t, y, *rates):
        return [-math.prod(rates) * y[0], y[0] * y[1]]

    def low(t, y, *rates):
        return y[0] - 0.8 * rates[0]

    for rates in ((1.0,), (0.9, 0.5), (0.9, 0.5, 2.0)):
        found = solve_ensemble(decays, (0, 1), STARTS, rates, "RK23", events=low, rtol=1e-6)
        expected = np.log(STARTS[:, 0] / 0.8 / rates[0]) / math.prod(rates)
        assert found.width > 1
        assert np.allclose(np.concatenate(found.t_events[0]), expected[expected < 1.0], rtol=1e-4)
        assert rates == (1.0,) or not made
        made.clear()
