"""One ensemble cut in blocks: the problem, executors that watch, equality to the bit."""

import json
from concurrent.futures import Executor

import numpy as np

G = 2.0

M = 333


def pendulum(t, w, a, damping):
    theta, omega = w
    return [omega, -a * G * np.sin(theta) - damping * omega]


def bottom(t, w, a, damping):
    return w[0]


def problem(**changes):
    given = {
        "fun": pendulum, "t_span": (0, 20), "y0": [1.0, 0.0],
        "args": (np.linspace(1.0, 9.0, M), 0.1), "t_eval": np.linspace(0, 20, 11),
    }  # fmt: skip
    return given | changes


def assert_same(one, other):
    names = ["t", "y", "y_end", "t_end", "status", "nfev", "n_accepted", "n_rejected"]
    for name in names:
        a, b = getattr(one, name)[:], getattr(other, name)[:]
        assert a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(), name
    assert repr(one) == repr(other)
    assert list(one.reduced) == list(other.reduced)
    for name in one.reduced:
        assert one.reduced[name].tobytes() == other.reduced[name].tobytes()
    for name in ("t_events", "y_events"):
        for a, b in zip(getattr(one, name) or [], getattr(other, name) or [], strict=True):
            assert [x.tobytes() for x in a] == [x.tobytes() for x in b]
    assert one[7].message == other[7].message and one[7].y.tobytes() == other[7].y.tobytes()


class Watched(Executor):
    """Counts what is submitted, and does something before one of them."""

    def __init__(self, executor, at=None, action=None):
        self.executor, self.at, self.action, self.futures = executor, at, action, []
        self._max_workers = executor._max_workers

    def submit(self, fn, /, *args, **kwargs):
        if len(self.futures) == self.at:
            self.action()
        self.futures.append(self.executor.submit(fn, *args, **kwargs))
        return self.futures[-1]


def in_python(t, w, a, damping):
    return [w[1], -a * w[0] * json.loads("1")]


def slow():
    return problem(t_span=(0, 2000), rtol=1e-9, events=bottom)
