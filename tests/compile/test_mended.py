"""A function that raised, and was mended, is traced at its next call."""

import types

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near

RIGHT = {"g": 9.81, "k": 1.0, "l": [1.0, 2.0], "m": 1.0, "n": 1.0}
CASES = {
    "del g": ("-g", NameError),
    "del table['k']": ("-table['k']", KeyError),
    "part.l = [1.0]": ("-part.l[1]", IndexError),
    "part.m = None": ("-part.m", TypeError),
    "del part.n": ("-part.n", AttributeError),
}


def mend(names):
    names.update(RIGHT)
    names["table"].update(RIGHT)
    vars(names["part"]).update(RIGHT)


@pytest.mark.parametrize("n_failures", [1, 5])
@pytest.mark.parametrize("breaks", CASES)
def test_a_refusal_for_an_exception_of_the_user_is_forgotten(breaks, n_failures):
    text, kind = CASES[breaks]
    names = {"table": {}, "part": types.SimpleNamespace()}
    mend(names)
    fun = eval(f"lambda t, y: [{text} * {1 + n_failures / 8} * y[0]]", names)
    exec(breaks, names)
    for _ in range(n_failures):
        with pytest.raises(kind):
            fastdyn.solve_ivp(fun, (0, 1), [1.0])
    mend(names)
    fastdyn.solve_ivp(fun, (0, 1), [1.0])
    bound = bind(fun, (), DERIVATIVE, 1, Near(0.0, 1.0, np.ones(1)))
    assert bound.function is not None and bound.function.traced is not None
