"""An oscillator by each method, with kernels that come compiled; `check_wheel` runs it."""

import math
import sys

import fastdyn
from fastdyn.code_store import COUNTS
from fastdyn.code_store.key import sources
from fastdyn.kernels.methods import METHODS


def oscillator(t, y, k):
    x, v = y
    return [v, -k * x]


def rotation(t, y):
    return [1j * y[0]]


def read_imports(contents):
    raise AssertionError("the wheel brings no hashes of its sources: a first process takes 0.8 s")


assert fastdyn.__file__.startswith(sys.argv[1]), fastdyn.__file__
sources._computed = read_imports
for name, method in METHODS.items():
    size = {"rtol": 1e-8, "atol": 1e-8} if method.error_order else {"step": 0.01}
    for wanted in ({}, {"t_eval": [0.0, 0.7, 2.0]}, {"dense_output": True}):
        given = {"args": (4.0,), "compile": "shared", **size, **wanted}
        result = fastdyn.solve_ivp(oscillator, (0, 2), [1.0, 0.0], name, **given)
        assert abs(result.y[0, -1] - math.cos(4.0)) < 1e-3, (name, result.y[0, -1])
for name in ("RK45", "DOP853", "RK4"):
    step = {"step": 0.01} if name == "RK4" else {}
    result = fastdyn.solve_ivp(rotation, (0, 1), [1.0 + 0j], name, **step)
    assert abs(result.y[0, -1] - complex(math.cos(1), math.sin(1))) < 1e-2, name
event = lambda t, y, k: y[0]  # noqa: E731
result = fastdyn.solve_ivp(oscillator, (0, 2), [1.0, 0.0], args=(4.0,), events=event)
assert abs(result.t_events[0][0] - math.pi / 4) < 1e-2
assert not {"numba", "scipy", "matplotlib"} & set(sys.modules)
print(f"{len(METHODS)} methods: {COUNTS}")
# The oscillator as derivative and acceleration, its Jacobian without and with the time derivative,
# and its series; the rotation, the event; the elimination of its matrices, which factorises and
# solves, real and complex ones.
assert COUNTS["compiled"] == 11
