"""Which exceptions the user's code catches: in ``try`` and ``with``, not in comprehensions.

From Python 3.12 on, comprehensions and generators have handlers of their own.
"""

import contextlib
import sys

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.trace.paths.handlers import is_handled


def comprehension(ask):
    return max([ask() for _ in range(1)])


def generator(ask):
    return next(ask() for _ in range(1))


def nested(ask):
    return max([max([ask() for _ in range(1)]) for _ in range(1)])


def in_a_handler(ask):
    try:
        raise ValueError
    except ValueError:
        return ask()


def in_try(ask):
    try:
        return ask()
    except ValueError:
        return None


def comprehension_in_try(ask):
    try:
        return max([ask() for _ in range(1)])
    except ValueError:
        return None


def called_in_try(ask):
    try:
        return generator(ask)
    except ValueError:
        return None


def in_with(ask):
    with contextlib.suppress(ValueError):
        return max([ask() for _ in range(1)])


def handler_in_try(ask):
    try:
        return in_a_handler(ask)
    except KeyError:
        return None


CAUGHT = [in_try, comprehension_in_try, called_in_try, in_with, handler_in_try]
NOT_CAUGHT = [comprehension, generator, nested, in_a_handler]


@pytest.mark.parametrize("function", [*CAUGHT, *NOT_CAUGHT])
def test_handlers(function):
    here = sys._getframe().f_code
    assert function(lambda: is_handled(here)) == (function in CAUGHT)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("divided", [lambda n: n % 3, lambda n: n // 2, lambda n: n / 4])
def test_a_whole_number_divided_by_a_number_of_the_code(divided):
    """No division by zero can raise there, so that Python's and NumPy's numbers divide alike."""
    levels = np.array([0.5, 0.25, 2.0, 1.5, 1.0])

    def fun(t, y):
        try:
            level = levels[int(divided(int(4 * t)))]
        except IndexError:
            level = 0.0
        return [level - y[0]]

    mine = fastdyn.solve_ivp(fun, (0.0, 2.0), [1.0], max_step=0.1)
    theirs = scipy.integrate.solve_ivp(fun, (0.0, 2.0), [1.0], max_step=0.1)
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-12)


def test_a_division_by_a_whole_number_of_the_state_is_left_to_python():
    def fun(t, y):
        try:
            return [1.0 / (6 // int(y[0])) - y[0]]
        except ZeroDivisionError:
            return [1.0]

    with pytest.warns(fastdyn.CompileWarning, match="may be caught"):
        fastdyn.solve_ivp(fun, (0.0, 2.0), [0.5])
