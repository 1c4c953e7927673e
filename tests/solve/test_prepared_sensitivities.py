"""A prepared solver, and repeated calls, give the sensitivities of a first solve."""

import math
import threading

import numpy as np
import pytest

import fastdyn.solve.prepare
from fastdyn import prepare, solve_ivp

GIVEN = {"rtol": 1e-6, "atol": 1e-8, "compile": "shared", "t_eval": [1.0, 2.5, 4.0]}
SPAN = 0, 4


def swing(t, y, k, weights):
    return [y[1], -k * np.sin(y[0]) - weights[0] * y[1] + weights[1]]


ARGS = 2.0, np.array([0.1, 0.3])
OTHERS = [  # values above 1 change the tolerances of columns
    ([0.5, -0.2], (7.5, np.array([0.2, -3.0]))),
    ([40.0, 0.0], (0.3, np.array([0.2, 0.0]))),
    ([1, 0], (2, np.array([0.1, 0.3]))),
    (np.array([0.5, -0.2]), (7.5, [0.2, -3.0])),
]


def same(a, b):
    assert (a.t == b.t).all() and (a.y == b.y).all() and a.nfev == b.nfev
    assert list(a.sensitivity) == list(b.sensitivity)
    for name, found in a.sensitivity.items():
        assert np.array_equal(found, b.sensitivity[name]), name


def test_other_arguments_are_of_the_kinds_of_the_first():
    solver = prepare(swing, SPAN, [1.0, 0.0], args=ARGS, **GIVEN, sensitivity=("y0", "weights"))
    with pytest.raises(TypeError, match="array of floats"):
        solver(*OTHERS[3])
    same(
        solver(),
        solve_ivp(swing, SPAN, [1.0, 0.0], args=ARGS, **GIVEN, sensitivity=("y0", "weights")),
    )
    with pytest.raises(ValueError, match="finite"):
        solver([np.nan, 0.0])


def test_calls_after_the_first_check_nothing_anew(monkeypatch):
    both = {**GIVEN, "sensitivity": "k"}
    solver = prepare(swing, SPAN, [1.0, 0.0], args=ARGS, **both)
    expected = [solver(y0, args) for y0, args in OTHERS[:2]]

    def never(*given):
        raise AssertionError("the long way")

    monkeypatch.setattr(fastdyn.solve.prepare, "solve_with_sensitivities", never)
    for (y0, args), known in zip(OTHERS[:2], expected, strict=True):
        same(solver(y0, args), known)


def test_threads_have_their_own_runs():
    both = {**GIVEN, "sensitivity": ("y0", "k")}
    solver = prepare(swing, SPAN, [1.0, 0.0], args=ARGS, **both)
    known = [solver(y0, args) for y0, args in OTHERS[:3]]
    found = {}

    def many(i):
        found[i] = [solver(*OTHERS[i]) for _ in range(30)]

    threads = [threading.Thread(target=many, args=(i,)) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i, results in found.items():
        for result in results:
            same(result, known[i])
    assert len(found) == 3


@pytest.mark.parametrize(
    ("fun", "options", "error", "words"),
    [
        (lambda t, y, k, w: [math.gamma(y[0]), 1.0], {}, ValueError, "tgamma"),
        (swing, {"sensitivity": "g"}, ValueError, "choose from 'y0', 'args', 'k', 'weights'"),
        (swing, {"callback": print}, TypeError, "takes no `callback`"),
    ],
)
def test_what_has_no_sensitivities_is_told_at_once(fun, options, error, words):
    with pytest.raises(error, match=words):
        prepare(fun, SPAN, [1.0, 0.0], args=ARGS, **{"sensitivity": "y0", **options})


def test_many_is_for_states_alone():
    solver = prepare(swing, SPAN, [1.0, 0.0], args=ARGS, **GIVEN, sensitivity="k")
    with pytest.raises(ValueError, match="`many` computes no sensitivities"):
        solver.many([[1.0, 0.0]])
