"""What an ensemble is given: shapes that fit, and sentences for the rest."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.integrate import OdeSolver

from fastdyn import solve_ensemble
from support.many import oscillator


@pytest.mark.hunt
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, 12), st.integers(0, 12), st.booleans(), st.booleans())
def test_shapes_broadcast_or_are_refused(a, b, two_states, list_given):
    k = np.linspace(1, 2, a)
    y0 = np.ones((b, 2)) if two_states else [1.0, 0.0]
    given_k = list(k) if list_given else k
    if two_states and a != b and 1 not in (a, b):
        with pytest.raises(ValueError, match=r"one entry a trajectory"):
            solve_ensemble(oscillator, (0, 1), y0, (given_k,))
        return
    result = solve_ensemble(oscillator, (0, 1), y0, (given_k,))
    count = (b if a == 1 else a) if two_states else a
    assert len(result) == count and result.y.shape == (count, 2)


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"method": OdeSolver}, ValueError, "own methods"),
        ({"y0": [[1.0, np.nan]]}, ValueError, "trajectory 0"),
        ({"y0": np.ones((2, 2, 2))}, ValueError, "shape"),
        ({"args": (np.ones((2, 2)),)}, ValueError, "Shared"),
        ({"args": (["a"],)}, ValueError, "numbers"),
        ({"reduce": "entropy"}, ValueError, "choose from max"),
        ({"reduce": "first_event"}, ValueError, "needs `events`"),
        ({"simd": "many"}, ValueError, "choose from auto"),
        ({"checkpoint": "x"}, TypeError, "takes no `checkpoint`"),
        ({"t_span": (1, 1)}, ValueError, "empty"),
        ({"reduce": "mean", "method": "VelocityVerlet", "step": 0.1}, ValueError, "RK4"),
        ({"fun": lambda t, w, k: [1.0]}, ValueError, "state of 2"),
    ],
)
def test_mistakes_are_named(change, error, says):
    given = {"fun": oscillator, "t_span": (0, 1), "y0": [1.0, 0.0], "args": (np.ones(3),)}
    with pytest.raises(error, match=says):
        solve_ensemble(**(given | change))
