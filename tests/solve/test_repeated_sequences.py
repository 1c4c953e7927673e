"""Calls of one function in any order, while what the function reads changes between them."""

import random

import numpy as np
import pytest

from fastdyn import solve_ivp
from support.repeated import assert_same, plain, was_ready

SOURCE = """
import math
import numpy as np

STRENGTH, MATRIX, FACTORS, NAMED = 9.0, np.array([1.0, 2.0]), [1.0, 2.0], {"a": 1.0, "b": 0.5}

def pull(x, w=1.0):
    return w * math.sin(x)

def with_defaults(t, y, k=9.0, c=0.1):
    return [y[1], -k * math.sin(y[0]) - c * y[1]]

def with_a_global(t, y):
    return [y[1], -STRENGTH * y[0]]

def with_an_array(t, y, c=1.0):
    return [y[1], -MATRIX[0] * y[0] - c * MATRIX[1] * y[1]]

def with_a_list(t, y):
    return [y[1], -FACTORS[0] * y[0] - FACTORS[1] * y[1]]

def with_any_number(t, y, *factors):
    return [y[1], -sum(factors) * y[0]]

def with_a_dict(t, y, p=NAMED):
    return [y[1], -p["a"] * y[0] - p["b"] * y[1]]

def with_none(t, y, k=None):
    return [y[1], -(2.0 if k is None else k) * y[0]]

def with_a_function(t, y, w=2.0):
    return [y[1], -pull(y[0], w) - pull(y[1])]

def with_a_keyword(t, y, *, k=3.0):
    return [y[1], -k * y[0]]
"""
NUMBERS = [1.0, 2.0, 3.5, 4, np.float64(2.5), 0.0, True]
FUNCTIONS = SOURCE.split("def ")[2:]
ARGUMENTS = {
    "with_defaults": [(4.0,), (4.0, 0.5), (2,)], "with_an_array": [(3.0,), (0.0,)],
    "with_any_number": [(1.0,), (1.0, 2.0), (3,)], "with_none": [(None,), (5.0,)],
    "with_a_dict": [({"a": 3.0, "b": 0.0},), ({"b": 3.0, "a": 0.0},)],
    "with_a_function": [(1.0,), (0.0,)],
}  # fmt: skip


def changes(draw, scope, fun):
    """Changes of what the functions read, by their names."""

    def default():
        fun.__defaults__ = fun.__defaults__ and (draw.choice(NUMBERS), *fun.__defaults__[1:])

    return [
        lambda: scope.update(STRENGTH=draw.choice(NUMBERS)),
        lambda: scope["MATRIX"].__setitem__(0, draw.choice(NUMBERS)),
        lambda: scope.update(MATRIX=np.array([draw.choice(NUMBERS), 2.0])),
        lambda: scope["FACTORS"].__setitem__(1, draw.choice(NUMBERS)),
        lambda: scope["NAMED"].__setitem__(draw.choice("ab"), draw.choice(NUMBERS)),
        lambda: setattr(scope["pull"], "__defaults__", (draw.choice(NUMBERS),)),
        default if fun.__name__ != "with_a_dict" else (lambda: None),
    ]


@pytest.mark.few
@pytest.mark.parametrize("method", ["RK45", "Taylor", "BDF"])
@pytest.mark.parametrize("name", [text.split("(")[0] for text in FUNCTIONS])
def test_calls_in_any_order(name, method):
    draw, scope, n_plain = random.Random(name + method), {}, 0
    exec(SOURCE, scope)
    fun = scope[name]
    for _ in range(60):
        if draw.random() < 0.25:
            draw.choice(changes(draw, scope, fun))()
        given = {
            "t_span": draw.choice([(0.0, 1.0), (0, 0.5), (1.0, 0.0)]), "method": method,
            "y0": draw.choice([[0.5, 0.25], (0.5, 1), np.array([1.0, -1.0])]),
            "args": draw.choice([None, (), *ARGUMENTS.get(name, ())]),
        }  # fmt: skip
        mine = solve_ivp(fun, **given)
        n_plain += was_ready(mine)
        assert_same(plain(fun, **given), mine)
    assert n_plain or name in ("with_none", "with_a_keyword")
