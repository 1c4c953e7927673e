"""SciPy's waveforms, softmax and logsumexp, written out as operations of the graph."""

from typing import Any

import numpy as np

from ..symbols.arrays import Array, elementwise
from ..symbols.conditions import select
from ..symbols.real import symbol
from ..symbols.symbolic import graph_of, is_symbolic, refuse


def _share(value):
    if is_symbolic(value) or np.ndim(value) or not 0 <= value <= 1:
        refuse("a waveform whose shape depends on the state")
    return float(value)


def _in_a_period(t):
    return symbol(graph_of(t), t) % (2 * np.pi)


def square(t, duty=0.5):
    """scipy.signal.square."""
    on = _share(duty) * 2 * np.pi
    return elementwise(lambda v: select(_in_a_period(v) < on, 1.0, -1.0), t)


def sawtooth(t, width=1.0):
    """scipy.signal.sawtooth."""
    w = _share(width)

    def one(v):
        phase = _in_a_period(v)
        up = phase / (np.pi * w) - 1 if w else phase
        down = (np.pi * (w + 1) - phase) / (np.pi * (1 - w)) if w < 1 else phase
        return select(phase < w * 2 * np.pi, up, down)

    return elementwise(one, t)


def softmax(x: Any, axis=None):
    """scipy.special.softmax."""
    x = Array.of(x)
    powers = np.exp(x - np.max(x, axis=axis, keepdims=True))
    return powers / np.sum(powers, axis=axis, keepdims=True)


def logsumexp(a: Any, axis=None):
    """scipy.special.logsumexp."""
    a = Array.of(a)
    largest = np.max(a, axis=axis, keepdims=True)
    total = np.log(np.sum(np.exp(a - largest), axis=axis, keepdims=True)) + largest
    return np.squeeze(total, axis=axis) if axis is not None else total.reshape(-1)[0]
