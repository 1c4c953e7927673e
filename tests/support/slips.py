"""Slips and the sentences that answer them: a row is what differs from a right call, and words.

The words are a part of the message, or of its note, or of a warning.  Each slip is answered before
anything is compiled: `fun` is never called.
"""

import warnings

import numpy as np
import pytest

NUMBER, NUMBERS = "must be a number; got ", "must be a number, or a number for each component; got "
SPAN, FLAG = "`t_span` must be start and end; got ", "must be True or False; got "
FUNCTION = "`fun` must be a function of (t, y)"
MATRIX = "must be a matrix of numbers"


class Reached(Exception):
    """Raised by a function that no slip should reach."""


def fun(t, y, *args):
    raise Reached


def hit(**attributes):
    def hit(t, y):
        raise Reached

    vars(hit).update(attributes)
    return hit


def said_to(call, given, kind=None):
    """The message of the exception with its notes, or the warnings if the call went through.

    The exception is one of the class `kind`, if a row of a table names one.
    """
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            call(**given)
        except Reached:
            pass
        except (TypeError, ValueError, OverflowError) as error:
            assert kind in (None, type(error))
            return "\n".join([str(error), *getattr(error, "__notes__", ())])
    assert kind is None
    return "\n".join(str(one.message) for one in heard)


def of_kind(kind, rows):
    """Rows with the class of their exceptions."""
    return [(*row, kind) for row in rows]


def rows_of(table):
    """The parameters (call, arguments, words, class of the exception or None) of a table.

    The table is {name: (call, a right call, rows)}; a row has what differs from the right call,
    words, and perhaps the class.
    """
    return [
        pytest.param(
            call, base | given, words, *(kind or [None]), id=f"{name} {' '.join(given)} {i}"
        )
        for name, (call, base, rows) in table.items()
        for i, (given, words, *kind) in enumerate(rows)
    ]


FUNCTIONS = [
    ({"fun": None}, f"{FUNCTION}; got None"),
    ({"fun": "pendulum"}, f"{FUNCTION}; got the text 'pendulum'"),
    ({"fun": [0.0, 1.0]}, f"{FUNCTION} (the function itself, not what it returns); got [0.0"),
    ({"fun": np.zeros(2)}, "not what it returns); got an array of shape (2,)"),
]
SPANS = [
    ({"t_span": 10}, f"{SPAN}10: (0, 10)?"),
    ({"t_span": 2.5}, f"{SPAN}2.5: (0, 2.5)?"),
    ({"t_span": None}, f"{SPAN}None."),
    ({"t_span": "01"}, f"{SPAN}the text '01'"),
    ({"t_span": ("0", "1")}, f"{SPAN}('0', '1')"),
    ({"t_span": (0, "x")}, f"{SPAN}(0, 'x')"),
    ({"t_span": (0, 1, 2)}, "times of output are `t_eval`"),
    ({"t_span": np.linspace(0, 1, 5)}, "times of output are `t_eval`"),
    ({"t_span": (0,)}, f"{SPAN}(0,)."),
    ({"t_span": np.eye(2)}, f"{SPAN}an array of shape (2, 2)"),
    ({"t_span": {0, 1}}, SPAN),
    ({"t_span": fun}, SPAN),
]
STATES = [
    ({"y0": 1.0}, "y0=[1.0]"),
    ({"y0": None}, "`y0` must be numbers; got None"),
    ({"y0": "1, 0"}, "`y0` must be numbers; got the text '1, 0'"),
    ({"y0": ["1", "0"]}, "`y0` must be numbers; got ['1', '0']", TypeError),
    ({"y0": np.array(["1"])}, "`y0` must be numbers", TypeError),
    ({"y0": [b"1"]}, "`y0` must be numbers", TypeError),
    ({"y0": [1.0, "x"]}, "`y0` must be numbers; got [1.0, 'x']"),
    ({"y0": [1.0, None]}, "All components of the initial state `y0` must be finite"),
    ({"y0": {"x": 1.0}}, "`y0` must be numbers; got {'x': 1.0}"),
    ({"y0": fun}, "`y0` must be numbers; got <function"),
    ({"y0": [[1.0], [0.0]]}, "It has shape (2, 1): a row or a column becomes a state by np.ravel"),
    ({"y0": [[1.0, 0.0]]}, "It has shape (1, 2): a row or a column"),
    ({"y0": np.ones((3, 2))}, "It has shape (3, 2): one solve has one state; fastdyn.solve_ensemb"),
    ({"y0": [[1.0], [2.0, 3.0]]}, "`y0` must be numbers in a row; got [[1.0]"),
]
STEPS = [
    ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"rtol": True}, f"`rtol` {NUMBERS}True"),
    ({"rtol": None}, f"`rtol` {NUMBERS}None"),
    ({"rtol": 1j}, f"`rtol` {NUMBERS}1j"),
    ({"rtol": {"x": 1.0}}, f"`rtol` {NUMBERS}{{"),
    ({"rtol": -1}, "`rtol` must not be negative; got -1"),
    ({"rtol": [1e-3, -1e-3]}, "`rtol` must not be negative; got [ 0.001 -0.001]"),
    ({"rtol": np.nan}, "`rtol` must not be NaN"),
    ({"atol": -1e-6}, "`atol` must be positive"),
    ({"rtol": [1e-3] * 3}, "It has shape (3,), and `y0` has 2 components."),
    ({"atol": "small"}, f"`atol` {NUMBERS}the text 'small'"),
    ({"atol": ["1e-3", "1e-3"]}, f"`atol` {NUMBERS}['1e-3', '1e-3']"),
    ({"atol": [1e-3, None]}, f"`atol` {NUMBERS}[0.001, None]"),
    ({"atol": [1, 2], "y0": [0.0] * 3}, "It has shape (2,), and `y0` has 3 components."),
    ({"atol": [[1e-3], [1e-3]]}, "It has shape (2, 1), and `y0` has 2 components."),
    ({"max_step": "x"}, f"`max_step` {NUMBER}the text 'x'"),
    ({"max_step": [0.1, 0.2]}, f"`max_step` {NUMBER}[0.1, 0.2]"),
    ({"max_step": True}, f"`max_step` {NUMBER}True"),
    ({"max_step": 1j}, f"`max_step` {NUMBER}1j"),
    ({"first_step": "a"}, f"`first_step` {NUMBER}the text 'a'"),
    ({"first_step": fun}, f"`first_step` {NUMBER}<function"),
    ({"first_step": 2}, "`first_step=2` is longer than `t_span`, 1."),
]
