"""The `vjp` of a plain solve in repeated calls: a sweep whose memory is laid out once.

A plain solve is one by an explicit method without events whose states are all kept.
Its `vjp` is a Vjp that holds the steps only, and becomes a whole one when more is asked.
"""

from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.code_store.call import address_of
from fastdyn.compile.parameters import n_words
from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.methods.adjoint import Seeds, Steps
from fastdyn.kernels.state.record import RUNNING
from fastdyn.kernels.stepping.backward import COSINE, LARGEST
from fastdyn.problem.sensitivities import START
from fastdyn.problem.step_options import NO_SEGMENTS
from fastdyn.specialise import scalar

from .backward import backward_of
from .vjp import ALWAYS_STABLE, Vjp

FLOAT = np.dtype(float)
MORE = 64  # steps, and outputs, for which a sweep has room at first


def _steps(n):
    """Room for n steps."""
    return Steps(*np.zeros((3, n)), np.zeros(n, np.int64))


class Laid:
    """The memory and the arguments of a sweep over plain solves of one kind, for one thread."""

    def __init__(self, backward, product, tolerances):
        n = product.n
        times = np.zeros(MORE)
        self._memory = memory = backward.room(product, np.zeros(n))
        none = np.zeros(1)
        states = np.zeros((1, n))
        block = np.zeros(1, np.int64)
        rows = np.zeros((len(times), n))
        beta = np.zeros(backward.n_weights)
        seeds = Seeds(times, none, rows, beta, np.zeros(1, np.int64))
        self._call = call = Call(
            scalar.sweep_whole_kernel(), *backward.fields, *_steps(MORE), NO_SEGMENTS, states,
            *seeds, block, block, *memory, np.zeros((n, MORE)), *tolerances,
        )  # fmt: skip
        names = "segments", "states", "seeds.t", "seeds.ends", "block", "own", "given.g"
        self._n = n
        self._places = [call.place(name) for name in names]
        self._room = self._points = MORE
        self._lam = backward.lam

    def over(self, t, states, segments, times, blocks, g):
        """Go back over a solve: the status, lam, the gradient behind n numbers, and the gauge.

        The arrays are those of the memory, and valid until the next call.
        """
        n_steps = len(t) - 1
        words = self._call.words
        if n_steps > self._room:
            self._room = 2 * n_steps
            for name, room in _steps(self._room)._asdict().items():
                self._call[f"steps.{name}"] = room
        of_segments, of_states, of_times, ends, own, pull, of_g = self._places
        own_block, block = blocks
        words[of_segments] = address_of(segments)
        words[of_segments + 1] = len(segments)
        words[ends] = address_of(t)
        words[ends + 1] = n_steps + 1
        words[of_states] = address_of(states)
        words[of_states + 1] = n_steps + 1
        n_points = len(times)
        if n_points > self._points:
            self._points = 2 * n_points
            self._call["seeds.g"] = np.zeros((self._points, self._n))
        words[of_times], words[of_g] = address_of(times), address_of(g)
        words[of_times + 1] = words[of_g + 2] = n_points
        words[own], words[own + 1] = address_of(own_block), len(own_block)
        words[pull], words[pull + 1] = address_of(block), len(block)
        memory = self._memory
        return self._call(), memory.work[self._lam], memory.out, memory.gauge


class Sweeps:
    """Sweeps over plain solves of one kind, in any number of threads."""

    def __init__(self, problem, product, directions):
        self._backward = backward_of(problem.method.name, product)
        tolerances = problem.rtol, np.full(product.n, problem.atol)
        self._given = self._backward, product, tolerances
        self._idle: list[Laid] = []
        self._parts = []
        begin = product.n
        for d in directions:
            if d.position == 0:
                self._parts.append((START, None, 0, 0))
                continue
            self._parts.append((d.name, d.value.shape, begin, begin + d.size))
            begin += d.size

    def over(self, *given):
        """The derivatives by name: see `Laid.over`; None if they are not finite, or not stable."""
        try:
            laid = self._idle.pop()
        except IndexError:
            laid = Laid(*self._given)
        status, lam, out, gauge = laid.over(*given)
        found = None
        largest = gauge[LARGEST]
        if status == RUNNING and (
            largest < ALWAYS_STABLE or largest <= self._backward.stable(gauge[COSINE])
        ):
            found = {}
            for name, shape, begin, end in self._parts:
                if shape is None:
                    found[name] = lam.copy()
                else:
                    found[name] = out[begin:end].copy().reshape(shape) if shape else out[begin]
        self._idle.append(laid)
        return found


class Values:
    """Where the words of a function's block name arrays, which a `vjp` copies."""

    def __init__(self, bound):
        self._arrays = []
        at = FIRST
        for i, (kind, _) in enumerate(bound.values):
            words = n_words(kind)
            if words and kind[0] == "array":
                self._arrays.append((i, at))
            at += words

    def copied(self, values, block):
        """The values with copies of the arrays, which the block then names."""
        if not self._arrays:
            return values
        values = list(values)
        for i, at in self._arrays:
            values[i] = own = np.array(values[i], order="C")
            block[at] = address_of(own)
        return values


class PlainVjp(Vjp):
    """The Vjp of a plain solve.

    Parameters
    ----------
    sweeps : Sweeps
    solve : tuple
        Times of the steps, their states, the segments of the span, the times of the outputs, the
        blocks of the equations and of their product.
    whole : callable
        ``whole()`` is a Vjp of the same solve; it keeps what the blocks need.
    """

    def __init__(self, sweeps, solve, whole):
        self._sweeps = sweeps
        self._solve = solve
        self._whole = whole
        self._shape = solve[1].shape[1], len(solve[3])

    def __getattr__(self, name) -> Any:
        """An attribute of the whole Vjp, which is made now."""
        if self.__dict__.get("_sweeps") is None:  # there is none that is not made already
            raise AttributeError(name)
        self.__dict__ = {**vars(self._whole()), **self.__dict__, "_sweeps": None}
        return self.__dict__[name]

    def __call__(self, g=None, t_events=None, y_events=None):
        """As `Vjp`."""
        sweeps = self._sweeps
        if (
            sweeps is not None and t_events is None is y_events and isinstance(g, np.ndarray)
            and g.dtype == FLOAT and g.shape == self._shape
        ):  # fmt: skip
            found = sweeps.over(*self._solve, np.ascontiguousarray(g))
            if found is not None:
                return found
        return super().__call__(g, t_events, y_events)
