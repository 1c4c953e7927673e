"""Slips in calls from JAX, torch and PyTensor: what they share is checked once."""

import importlib
import importlib.util

import pytest

from fastdyn.solve.differentiable.given import Library, call_of
from support.slips import FUNCTIONS, NUMBER, NUMBERS, SPANS, fun, rows_of, said_to

LIBRARY = Library(  # without arrays: all numbers are fixed
    "JAX", lambda value: False, lambda value: False, str, tuple, lambda value: None, "float64"
)
OF_CALL = {
    "library": LIBRARY, "fun": fun, "t_span": (0, 1), "y0": [1.0, 0.0], "method": "RK45",
    "t_eval": None, "events": None, "args": (), "occurrences": 1, "options": {},
}  # fmt: skip
ROWS = [
    *FUNCTIONS,
    *SPANS,
    ({"y0": "1, 0"}, "`y0` must be numbers; got the text '1, 0'"),
    ({"y0": [[1.0, 0.0]]}, "It has shape (1, 2): a row or a column"),
    ({"method": "rk45"}, 'did you mean "RK45"?'),
    ({"t_eval": "abc"}, "`t_eval` must be a sequence of times; got the text 'abc'"),
    ({"t_eval": []}, "`t_eval` is empty: there is nothing to return"),
    ({"t_span": (0, float("inf"))}, "`t_span` ends at inf: derivatives need a finite span"),
    ({"events": 3}, "`events` must be a function of (t, y), or a sequence of functions; got 3"),
    ({"args": 9.81}, "args=(9.81,)"),
    ({"args": "abc"}, "`args` must be a tuple, args=('abc',)"),
    ({"occurrences": "x"}, "`occurrences` must be a whole number above 0; got 'x'"),
    ({"occurrences": 0}, "`occurrences` must be a whole number above 0; got 0"),
    ({"options": {"rtol": "1e-3"}}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"options": {"max_step": "x"}}, f"`max_step` {NUMBER}the text 'x'"),
    ({"options": {"dense_output": True}}, "`dense_output` is no option of fastdyn.jax.solve_ivp"),
    ({"options": {"adjoint": "y0"}}, "`adjoint` is no option of fastdyn.jax.solve_ivp"),
]
TABLE = {"solve_ivp of a library": (call_of, OF_CALL, ROWS)}


@pytest.mark.parametrize(("call", "given", "words", "kind"), rows_of(TABLE))
def test_a_slip_is_answered(call, given, words, kind):
    assert words in said_to(call, given, kind)


@pytest.mark.parametrize("name", ["jax", "torch", "pytensor"])
def test_a_door_without_its_library_names_it(name):
    if importlib.util.find_spec(name) is not None:
        pytest.skip(f"{name} is installed")
    with pytest.raises(ImportError, match=f"fastdyn.{name} needs {name}: python -m pip install"):
        importlib.import_module(f"fastdyn.{name}")
