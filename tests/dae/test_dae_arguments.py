"""Wrong arguments of `solve_dae` are answered by sentences."""

import math

import numpy as np
import pytest

from fastdyn import solve_dae
from tests.support.daes import linear

REFUSED = [
    (ValueError, "`F` returned 1 value for a state of 2", {"F": lambda t, y, yp: [yp[0]]}),
    (TypeError, "`F` returned None; it must return 2 numbers", {"F": lambda t, y, yp: None}),
    (TypeError, "`F` returned complex numbers", {"F": lambda t, y, yp: [1j, y[0]]}),
    (ValueError, "`F` returned nan or inf .*equation 1", {"F": lambda t, y, yp: [0, math.nan]}),
    (TypeError, "takes 2 positional arguments", {"F": lambda t, y: y}),
    (TypeError, "`F` must be a function", {"F": 3}),
    (ValueError, "`yp0` must have one number for each", {"yp0": [1.0]}),
    (ValueError, "`yp0` must be finite", {"yp0": [1.0, math.nan]}),
    (ValueError, "`y0` must be finite", {"y0": [math.inf, 0.0]}),
    (ValueError, "`y0` is empty", {"y0": []}),
    (TypeError, "`y0` is complex", {"y0": [1j, 0.0]}),
    (TypeError, "`yp0` is complex", {"yp0": [1j, 0.0]}),
    (ValueError, "must be 1-dimensional", {"y0": [[1.0, 0.0]]}),
    (ValueError, "`given` must be None, one of 'differential'", {"given": "algebraic"}),
    (ValueError, "4 booleans, for `y0`", {"given": [True, False]}),
    (ValueError, "4 booleans, for `y0`", {"given": [1.0, 2.0, 3.0, 4.0]}),
    (ValueError, "`t_span` must be two times", {"t_span": (0, math.nan)}),
    (ValueError, "nothing stops the run", {"t_span": (0, math.inf)}),
    (ValueError, "not within `t_span`", {"t_eval": [0, 9]}),
    (ValueError, "`rtol` has wrong shape", {"rtol": [1e-3, 1e-3, 1e-3]}),
    (ValueError, "`atol` must be positive", {"atol": -1.0}),
    (ValueError, "`max_step` must be positive", {"max_step": 0}),
    (ValueError, "`first_step` exceeds bounds", {"first_step": 10}),
    (ValueError, "`on_event` must have a function", {"on_event": lambda t, y: y}),
    (TypeError, "`on_event` must be a function", {"events": abs, "on_event": [3]}),
    (ValueError, "`breakpoints` must be a 1-D array", {"breakpoints": [[0.5]]}),
    (
        ValueError,
        "`checkpoint` of `solve_dae` does not go with .*breakpoints",
        {"checkpoint": "file", "breakpoints": [0.5]},
    ),
    (TypeError, "`callback` must be a function", {"callback": 3}),
    (TypeError, "no option `step` without a method", {"step": 0.1}),
    (ValueError, "`at` has the time 2.0, behind the end", {"at": [2.0]}),
    (ValueError, "`discrete` never changes", {"discrete": [1.0]}),
    (ValueError, "no `jac`: Jacobians are exact", {"jac": np.eye(2)}),
    (ValueError, "`method=.Euler.` is unknown", {"method": "Euler"}),
]


@pytest.mark.parametrize("error, said, changed", REFUSED)
def test_wrong_arguments_are_named(error, said, changed):
    arguments = {"F": linear, "t_span": (0, 1), "y0": [1.0, -1.0], **changed}
    with pytest.raises(error, match=said):
        solve_dae(**arguments)
