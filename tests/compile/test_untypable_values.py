"""What Numba can never take is refused in milliseconds, with a sentence, before it is imported."""

import enum
import os
import subprocess
import sys
import time
import types

import numba
import numpy as np
import pytest
from numba.experimental import jitclass

from fastdyn.compile.callables.diagnostics import Uncompilable
from fastdyn.compile.callables.parts import parts_of
from fastdyn.compile.callables.untypable_values import refuse_at_sight


class Plain:
    def __init__(self):
        self.table = {"k": 2.0}
        self.k = 2.0

    def rates(self, t, y):
        return self.table["k"] * y

    def fine(self, t, y):
        return self.k * y


class Colour(enum.Enum):
    RED = 1


@jitclass([("k", numba.float64)])
class Compiled:
    def __init__(self):
        self.k = 2.0


table, objects, members, plain = {"k": 2.0}, [Plain(), Plain()], {1, 2}, Plain()
colour, compiled = Colour.RED, Compiled()
space = types.SimpleNamespace(k=2.0, table=table)


def helper(x):
    return table["k"] * x


def closed_over():
    inside = {"k": 1.0}
    return lambda t, y: inside["k"] * y


REFUSED = {
    "global": (lambda t, y: table["k"] * y, (), "`table`, of type dict"),
    "closure": (closed_over(), (), "`inside`, of type dict"),
    "attribute": (lambda t, y: plain.table["k"] * y, (), "`plain.table`, of type dict"),
    "name space": (lambda t, y: space.table["k"] * y, (), "`space.table`, of type dict"),
    "self": (plain.rates, (), "`self.table`, of type dict"),
    "helper": (lambda t, y: helper(y), (), "`table`, of type dict"),
    "argument": (lambda t, y, p: p["k"] * y, (table,), "of type dict"),
    "object": (lambda t, y, p: p.k * y, (plain,), "of type Plain"),
    "objects": (lambda t, y: sum([o.k for o in objects]) * y, (), "`objects`, of type list"),
    "set": (lambda t, y: y * (1 in members), (), "`members`, of type set"),
    "enum": (lambda t, y: y if colour is Colour.RED else -y, (), "compares identities"),
}
FINE = {
    "attribute": (lambda t, y: plain.k * y, ()),
    "name space": (lambda t, y: space.k * y, ()),
    "self": (plain.fine, ()),
    "jitclass": (lambda t, y: compiled.k * y, ()),
    "array": (lambda t, y, a, s: y, (np.ones(2), "text")),
    "function": (lambda t, y: np.linalg.norm(y) * y, ()),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_numba_never_takes_is_refused_at_once(name):
    fun, args, said = REFUSED[name]
    begin = time.perf_counter()
    with pytest.raises(Uncompilable, match=said):
        refuse_at_sight(parts_of(fun, args))
    assert time.perf_counter() - begin < 0.1


@pytest.mark.parametrize("name", FINE)
def test_what_numba_may_take_is_not(name):
    fun, args = FINE[name]
    refuse_at_sight(parts_of(fun, args))


SCRIPT = """
import sys
import fastdyn
table = {"k": 2.0}

def rates(t, y):
    x = y[0]
    while x < 50.0:
        x = x * 1.01 + abs(y[1])
    return [table["k"] * y[1], -y[0] + 1e-9 * x]

assert fastdyn.solve_ivp(rates, (0, 1), [0.3, 0.5], compile="shared").success
print("numba" in sys.modules)
"""


def test_numba_is_not_even_imported():
    import fastdyn

    fastdyn.solve_ivp(lambda t, y: -y, (0, 1), [1.0, 1.0], compile="shared")  # kernels are there
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=120,
        env=dict(os.environ),
    )  # fmt: skip
    assert done.stdout == "False\n"
    assert "it uses `table`, of type dict, which compiled code cannot hold" in done.stderr
