"""Which exceptions the user's code catches: in ``try`` and ``with``, not in comprehensions.

From Python 3.12 on, comprehensions and generators have handlers of their own.
"""

import contextlib
import sys

import pytest

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
