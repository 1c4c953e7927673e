"""Index reduction remembers a structure, which holds for all values of the parameters."""

import functools
import threading

import numpy as np
import pytest

from fastdyn import solve_dae
from fastdyn.compile import memory
from fastdyn.dae.structure import differentiate, reduce_index, reduction
from support.mechanisms import ANDREWS_START, andrews, from_angle, pendulum

reduced = functools.partial(solve_dae, method="DOP853")
ARGS = (1.0, 9.81)


@pytest.fixture
def counted(monkeypatch):
    """How often a structure was analysed."""
    calls = []
    analyse = differentiate.differentiated
    monkeypatch.setattr(
        reduction, "differentiated", lambda *given: calls.append(1) or analyse(*given)
    )
    memory.forget()
    return calls


def test_a_function_is_analysed_once(counted):
    first = reduced(pendulum, (0, 1), from_angle(0.5, 0.0, *ARGS), args=ARGS)
    n = len(counted)
    for angle, length in ((0.5, 1.0), (1.0, 2.0), (-2.0, 0.3)):
        args = length, 9.81
        solve_dae(pendulum, (0, 1), from_angle(angle, 0.0, *args), args=args)
    assert n and len(counted) == n
    memory.forget()
    again = reduced(pendulum, (0, 1), from_angle(0.5, 0.0, *ARGS), args=ARGS)
    assert len(counted) == 2 * n and np.array_equal(first.y, again.y)


def test_results_do_not_depend_on_what_is_remembered():
    memory.forget()
    args = (0.5, 9.81)
    fresh = reduced(pendulum, (0, 1), from_angle(1.0, 0.5, *args), args=args)
    memory.forget()
    for other in (2.0, 1, np.float64(3.0)):
        reduced(pendulum, (0, 1), from_angle(0.1, 0.0, other, 9.81), args=(other, 9.81))
    known = reduced(pendulum, (0, 1), from_angle(1.0, 0.5, *args), args=args)
    assert np.array_equal(fresh.y, known.y) and fresh.nfev == known.nfev


def branches(t, y, yp, how):
    """Other equations for another argument: index 1, 2 or 3."""
    x, v, force = y
    if how == "free":
        return [yp[0] - v, yp[1] + force, force - x]
    if how == "speed":
        return [yp[0] - v, yp[1] + force, v - np.cos(t)]
    return [yp[0] - v, yp[1] + force, x - np.sin(t)]


def test_a_structure_belongs_to_the_values_that_decide():
    for how, index in [("free", 1), ("place", 3), ("speed", 2), ("free", 1), ("place", 3)]:
        found = reduced(branches, (0, 1), [0.0, 1.0, 0.0], args=(how,), rtol=1e-9, atol=1e-9)
        assert found.index == index
        assert found.y[:2] == pytest.approx(np.array([np.sin(found.t), np.cos(found.t)]), abs=1e-8)


def test_a_structure_follows_what_is_read_outside():
    power = {"k": 1}

    def curve(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[2] ** power["k"], y[0] - np.cos(t)]

    for k in (1, 3, 1):
        power["k"] = k
        found = reduced(curve, (0, 1), [1.0, 0.0, 1.0], rtol=1e-9, atol=1e-9)
        assert found.y[2] == pytest.approx(np.cbrt(np.cos(found.t)) if k == 3 else np.cos(found.t))


def weighted(t, y, yp, a, b):
    """Two velocities of one point, and nothing that tells them apart if a b = 1."""
    return [yp[0] + y[2] + a * y[3], yp[1] + b * y[2] + y[3], y[0] - np.sin(t), y[1] - np.cos(t)]


def test_special_values_of_parameters_are_seen():
    start = [0.0, 1.0, 0.0, 0.0]
    for _ in range(2):
        assert reduced(weighted, (0, 1), start, args=(0.5, 0.5)).success
        with pytest.raises(ValueError, match="singular at t = 0, though its structure is regular"):
            reduced(weighted, (0, 1), start, args=(2.0, 0.5))


def test_pivots_are_those_of_the_present_values():
    """Elimination by a mass that is zero for other values is not taken from memory."""

    def chain(t, y, yp, m):
        x, v, force = y[:4], y[4:8], y[8:]
        pull = [force[0], force[1] - force[0], force[2] - force[1], -force[2]]
        return [
            *(yp[i] - v[i] for i in range(4)),
            *(m[i] * yp[4 + i] + pull[i] + x[i] for i in range(4)),
            *(x[i + 1] - x[i] - 1.0 for i in range(3)),
        ]

    start = [0.0, 1.0, 2.0, 3.0, *[0.0] * 7]
    ends = []
    for m in ([1.0, 1e-9, 1.0, 2.0], [1.0, 1.0, 1.0, 1.0], [1e-12, 2.0, 1.0, 1e-9]):
        memory.forget()
        fresh = reduced(chain, (0, 1), start, args=(np.array(m),))
        ends.append((m, fresh.y))
    for m, y in ends:
        assert np.array_equal(reduced(chain, (0, 1), start, args=(np.array(m),)).y, y)


def test_threads_that_analyse_one_function():
    memory.forget()
    expected = str(reduce_index(andrews, ANDREWS_START))
    memory.forget()
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(str(reduce_index(andrews, ANDREWS_START))))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 3
