"""Functions that stay in Python: what they may return, and what a solve with them costs."""

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.kernels.algebra.linear import SingularMatrixError
from fastdyn.run.loop import Run

pytestmark = pytest.mark.filterwarnings("ignore:.*runs in Python")
SPAN, START, LATER = (0.0, 1.0), [1.0, 0.5], 4  # the number of the first call with another value
FORMS = {
    "list": list,
    "tuple": tuple,
    "array": np.array,
    "numbers of NumPy": lambda v: [np.float64(v[0]), v[1]],
    "single precision": lambda v: np.array(v, np.float32),
    "whole and single": lambda v: [int(v[0]), np.float32(v[1])],
    "part of an array": lambda v: np.array([v, v]).T.ravel()[::2],
    "truth values": lambda v: [v[0] > 0.0, v[1] > 0.0],
    "objects": lambda v: np.array(v, object),
}
WRONG = {
    "text": lambda v: ["1.0", 2.0],
    "column": lambda v: np.array(v)[:, None],
    "nothing": lambda v: None,
    "too few": lambda v: v[:1],
    "too many": lambda v: [*v, 0.0],
    "a row": lambda v: np.array(v)[None],
    "complex": lambda v: [v[0] + 1j, v[1]],
    "uneven": lambda v: [v, v[1]],
}


def python_function(form, calls):
    """A function with an effect, in the usual form at first."""

    def fun(t, y):
        calls.append(t)
        value = [y[1], -y[0]]
        return value if len(calls) < LATER else form(value)

    return fun


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_the_form_of_a_value_changes_no_bit(form):
    def as_list(value):
        return np.asarray(form(value)).astype(float).ravel().tolist()

    mine, plain = (solve_ivp(python_function(each, []), SPAN, START) for each in (form, as_list))
    assert mine.nfev == plain.nfev and np.array_equal(mine.y, plain.y)


@pytest.mark.parametrize("form", WRONG.values(), ids=WRONG)
def test_a_later_value_is_checked_as_the_first(form):
    with pytest.raises((TypeError, ValueError)) as found:
        solve_ivp(python_function(form, [0.0] * LATER), SPAN, START)
    with pytest.raises(found.type) as later:
        solve_ivp(python_function(form, []), SPAN, START)
    assert str(later.value) == str(found.value)


def test_the_error_of_a_singular_matrix_tells_the_time():
    calls = []

    def fun(t, y):
        calls.append(t)
        if len(calls) > LATER:
            raise SingularMatrixError("singular")
        return [y[1], -y[0]]

    with pytest.raises(SingularMatrixError, match=r"At t = 0\.\d+, singular"):
        solve_ivp(fun, SPAN, START)


def test_a_solve_of_few_steps_is_one_call_of_a_kernel(monkeypatch):
    def never(*given):
        raise AssertionError

    fun = python_function(list, [])
    expected = solve_ivp(fun, SPAN, START)
    monkeypatch.setattr(Run, "_go_on", never)
    assert np.array_equal(solve_ivp(fun, SPAN, START).y, expected.y)
