"""Repeated calls on runs that are ready, and the same calls by the long way."""

import contextlib
import math
import threading

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from fastdyn.run import ready
from fastdyn.solve import repeated
from fastdyn.solve.prepare import Prepared

START = np.array([0.5, 0.25])


def closure(q):
    return lambda t, y: [y[1], -q * math.sin(y[0])]


def plain(*given, **named):
    """`solve_ivp` by the long way."""
    with the_long_way():
        return solve_ivp(*given, **named)


def in_threads(work, values):
    """Call ``work(value)`` for all values at once, each in a thread of its own."""
    threads = [threading.Thread(target=work, args=(value,)) for value in values]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


CALLS = 9  # by which a run is ready


@contextlib.contextmanager
def the_long_way():
    """All calls of `solve_ivp` within, and of solvers that are made within, go the long way."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("solved", "note", "choose"):
            patch.setattr(repeated, name, lambda *given: None)
        yield


_results, _last = ready.results, []


def _noted(*given):
    make = _results(*given)

    def noted(*given):
        _last[:] = [make(*given)]
        return _last[0]

    return noted


ready.results = _noted


def warm(call, *given, **named):
    """Call until a run is ready; the last result."""
    for _ in range(CALLS):
        result = call(*given, **named)
    return result


def was_ready(result):
    """Whether the last solve was plain, on a run that was ready."""
    return bool(_last) and result is _last[0]


def is_plain(call, *given, **named):
    """Whether calls are plain: one of two is where a comparison is due in the other."""
    warm(call, *given, **named)
    return any(was_ready(call(*given, **named)) for _ in range(2))


def assert_same(one, other):
    """All fields of two results are equal, to the last bit."""
    assert list(one) == list(other)
    for name in one:
        a, b = one[name], other[name]
        assert type(a) is type(b), name
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype and a.shape == b.shape and a.flags.f_contiguous, name
            assert a.tobytes() == b.tobytes(), name
        elif isinstance(a, list):
            assert [(each.shape, each.tobytes()) for each in a] == [
                (each.shape, each.tobytes()) for each in b
            ], name
        else:
            assert a == b, name


def assert_first(found, first):
    """All fields of a result are those of a first solve, to the last bit; `vjp` but for rounding.

    A sweep back over all steps adds in another order if the run has other memory.
    """
    assert list(found) == list(first)
    for name, expected in first.items():
        value = found[name]
        if name == "vjp" and expected is not None:
            g = np.ones(first.y.shape)
            ours, theirs = value(g), expected(g)
            assert list(ours) == list(theirs)
            for part in theirs:
                np.testing.assert_allclose(ours[part], theirs[part], rtol=1e-12)
        elif name == "sol" and expected is not None:
            times = np.linspace(first.t[0], first.t[-1], 17)
            np.testing.assert_array_equal(value(times), expected(times))
        else:
            assert type(value) is type(expected), name
            np.testing.assert_equal(value, expected, name)


def pendulum(t, y, damping=0.1):
    return [y[1], -9.81 * math.sin(y[0]) - damping * y[1]]


def oscillator(t, y):
    return [y[1], -9.81 * y[0]]


METHODS = {
    "RK45": {}, "DOP853": {}, "Tsit5": {}, "Vern9": {}, "ode45": {}, "Taylor": {}, "Radau": {},
    "BDF": {}, "LSODA": {}, "Rodas5P": {}, "RK4": {"step": 0.1}, "VelocityVerlet": {"step": 0.1},
    "Gauss8": {"step": 0.1},
}  # fmt: skip


def prepared(fun=pendulum, span=(0.0, 1.0), y0=START, method="RK45", t_eval=None, **options):
    if not METHODS.get(method):
        options.setdefault("rtol", 1e-6)
    return prepare(fun, span, y0, method, t_eval, compile="shared", **options)


class LongWay(Prepared):
    """A solver without runs that are ready."""

    def __call__(self, *given, **named):
        self._solver.idle = []
        return super().__call__(*given, **named)


def both_ways(fun=pendulum, *given, **named):
    """A solver whose run is ready, and one that goes the long way."""
    solver, plain = prepared(fun, *given, **named), prepared(fun, *given, **named)
    plain.__class__ = LongWay
    plain()
    warm(solver)
    return solver, plain
