"""Calls of the compiled entry, and the same calls without it."""

import contextlib
import math
import threading

import numpy as np

from fastdyn import prepare, solve_ivp
from fastdyn.compile import memory
from fastdyn.solve.entry import again, load

START = np.array([0.5, 0.25])


def closure(q):
    return lambda t, y: [y[1], -q * math.sin(y[0])]


def plain(*given, **named):
    """`solve_ivp` without the entry."""
    with switched_off():
        return solve_ivp(*given, **named)


def in_threads(work, values):
    """Call ``work(value)`` for all values at once, each in a thread of its own."""
    threads = [threading.Thread(target=work, args=(value,)) for value in values]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


CALLS = 9  # by which an entry is there


@contextlib.contextmanager
def switched_off():
    """Without the entry, in solvers that are made within."""
    code, refused, recent = load._State.code, load._State.refused, again._recent
    load._State.code, load._State.refused, again._recent = None, True, memory.Table()
    try:
        yield
    finally:
        load._State.code, load._State.refused, again._recent = code, refused, recent


def loaded():
    """Wait for the code of the entry."""
    assert load.is_here(60.0) or load.is_here(60.0)


def warm(call, *given, **named):
    """Call until the entry is there; the last result."""
    loaded()
    for _ in range(CALLS):
        result = call(*given, **named)
    return result


def by_c(result):
    """Whether a result was made by the entry."""
    return result._unmade is None and len(dict.keys(result)) == 13


def goes_by_c(call, *given, **named):
    """Whether calls go by the entry: one of two does where a comparison is due in the other."""
    warm(call, *given, **named)
    return any(by_c(call(*given, **named)) for _ in range(2))


def assert_same(one, other):
    """All fields of two results are equal, to the last bit."""
    assert list(one) == list(other)
    for name in one:
        a, b = one[name], other[name]
        assert type(a) is type(b), name
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype and a.shape == b.shape and a.flags.f_contiguous, name
            assert a.tobytes() == b.tobytes(), name
        else:
            assert a == b, name


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


def in_c_and_python(fun=pendulum, *given, **named):
    """A solver whose entry is there, and one without entry."""
    with switched_off():
        plain = prepared(fun, *given, **named)
        plain()
    solver = prepared(fun, *given, **named)
    warm(solver)
    return solver, plain
