"""The kernels that go back over the steps of a method, with their table and their memory."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store import Call
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods.adjoint import (
    BlocksOfCollocation,
    BlocksOfRosenbrock,
    Memory,
    MemoryOfCollocation,
    MemoryOfRosenbrock,
    Seeds,
    collocation_of,
    kicks_of,
    rosenbrock_of,
    stable_kicks,
    stable_size,
    table_of,
)
from fastdyn.kernels.state.record import RUNNING
from fastdyn.kernels.stepping import (
    backward,
    backward_collocation,
    backward_rosenbrock,
    backward_splitting,
)
from fastdyn.run.matrices.layouts import SMALL, bandwidths, narrow_order
from fastdyn.specialise import scalar

MOST = 2**24  # numbers in the matrix of all stages: 128 MB
TOO_LARGE = (
    "`vjp` of {} would factorise a matrix of {} x {} numbers in each step, for all stages: take "
    "Rodas5P, or `sensitivity`."
)
NOT_FOUND = (
    "The equations of the step from t = {} cannot be solved again: `fun` has a kink there, or two "
    "solutions lie near. Take smaller tolerances or steps, another method, or `sensitivity`."
)


class Backward(NamedTuple):
    """The kernels that go back over the steps of one method, with their table.

    Attributes
    ----------
    fields : tuple
        Those of the table, one by one.
    sweep, replay : function
        They return kernels.
    n_rows, n_pairs, n_weights : int
        Rows of the work array; the number of pairs of rows at its begin, and of weights of an
        output.
    lam, scale : int
        The rows of the derivatives by the state at the begin of a step, before those carried to
        the step before; and of the scale of the states.
    stable : function or None
        ``stable(cosine)`` is the limit of h |J|, as the gauge of a sweep has it; None for methods
        that solve equations, whose steps are stable.
    memory_in, blocks : function
        ``memory_in(backward, work, product)``, the memory of a sweep with a work array; and
        ``blocks(bound, product)``, copies of the blocks of all functions, for one thread.
    """

    fields: tuple
    sweep: Any
    replay: Any
    n_rows: int
    n_pairs: int
    n_weights: int
    lam: int
    scale: int
    stable: Any
    memory_in: Any
    blocks: Any

    def room(self, product, scale):
        """The memory of a sweep over states of these sizes."""
        work = np.zeros((self.n_rows, len(scale)))
        work[self.scale] = scale
        return self.memory_in(self, work, product)

    def over(self, leg, t, g, blocks, memory):
        """Go back over a leg: the derivatives by the state at its begin.

        Those by the outputs at the times t are g; those by the parameters are added to the memory.
        """
        work = memory.work
        lam = self.lam
        work[lam : lam + 2] = 0.0
        seeds = Seeds(t, leg.t, g, np.zeros(self.n_weights), np.array([len(t)]))
        for first, states in self._segments(leg, blocks, memory):
            given = *self.fields, *leg.steps, first, states, *seeds, *blocks, *memory
            self._check(Call(self.sweep(), *given)(), memory)
        return work[lam].copy()

    def _check(self, status, memory):
        if status != RUNNING:
            raise ValueError(NOT_FOUND.format(memory.z[0]))

    def _segments(self, leg, blocks, memory):
        """Yield the number of the first step, and the states, of each segment from the last on."""
        if leg.is_whole:
            yield 0, leg.states
            return
        bounds = np.append(leg.rows, len(leg.t) - 1)
        room = np.empty((np.diff(bounds).max() + 1, leg.states.shape[1]))
        others = (*blocks, *memory) if self.stable is None else None
        for i in range(len(leg.rows) - 1, -1, -1):
            first = int(bounds[i])
            end = int(bounds[i + 1])
            states = room[: end - first + 1]
            if len(states) < 2:
                continue
            states[0] = leg.states[i]
            given = others or (blocks[0], np.zeros_like(memory.work))
            status = Call(self.replay(), *self.fields, *leg.steps, first, states, *given)()
            self._check(status, memory)
            yield first, states


def backward_of(name, product):
    """The Backward of a method for equations with this vjp.Product."""
    if BY_NAME[name].backward == "rosenbrock":
        return _rosenbrock(product)
    if BY_NAME[name].backward == "collocation":
        return _collocation(name, product)
    return _explicit(name)


def _rosenbrock(product):
    def memory(backward, work, product):
        n = product.n
        *_, ld = backward.fields
        entries = np.zeros(len(product.places[0]) + n)
        z = np.zeros(3 * n + 1)
        matrix = np.zeros((n - 1) * ld + n)
        out = np.zeros(n + product.m)
        return MemoryOfRosenbrock(work, out, entries, z, matrix, np.zeros(n))

    def blocks(bound, product):
        own = bound, product.jacobian, product.bound, product.along
        return BlocksOfRosenbrock(*[each.block.copy() for each in own])

    return Backward(
        tuple(rosenbrock_of(*product.places, _order(product))), scalar.sweep_of_rosenbrock_kernel,
        scalar.replay_of_rosenbrock_kernel, backward_rosenbrock.SINGLE, 0, 0,
        backward_rosenbrock.LAM, backward_rosenbrock.SCALE, None, memory, blocks,
    )  # fmt: skip


def _collocation(name, product):
    table = collocation_of(name, *product.places, _order(product))
    s, single = len(table.c), 3 * len(table.c)
    if s * product.n * table.ld > MOST:
        raise ValueError(TOO_LARGE.format(name, s * product.n, table.ld))

    def memory(backward, work, product):
        m = product.n
        size = s * product.n
        rows = np.zeros(m + product.m), np.zeros(len(table.rows)), np.zeros(size), np.zeros(2 * m)
        return MemoryOfCollocation(work, *rows, np.zeros((size - 1) * table.ld + size), rows[2] * 0)

    def blocks(bound, product):
        own = bound, product.jacobian, product.bound
        return BlocksOfCollocation(*[each.block.copy() for each in own])

    return Backward(
        tuple(table), scalar.sweep_of_collocation_kernel, scalar.replay_of_collocation_kernel,
        single + backward_collocation.SINGLE, 0, s, single + backward_collocation.LAM,
        single + backward_collocation.SCALE, None, memory, blocks,
    )  # fmt: skip


def _order(product):
    """The place of each component in a matrix: another one if the band becomes narrower."""
    rows, columns = product.places
    same = np.arange(product.n)
    if sum(bandwidths(rows, columns)) <= SMALL:
        return same
    found = narrow_order(product.n, rows, columns)
    narrower = sum(bandwidths(found[rows], found[columns])) < sum(bandwidths(rows, columns))
    return found if narrower else same


def _memory(backward, work, product):
    pairs = work[: 2 * backward.n_pairs].reshape(-1, 2 * work.shape[1])
    return Memory(work, pairs, np.zeros(product.n + product.m), np.zeros(3))


def _blocks(bound, product):
    return bound.block.copy(), product.bound.block.copy()


@functools.cache
def _explicit(name):
    if BY_NAME[name].backward == "kicks":
        table = kicks_of(name)
        first = len(BY_NAME[name].tableau["kicks"])
        return Backward(
            tuple(table), scalar.sweep_of_kicks_kernel, scalar.replay_of_kicks_kernel,
            first + backward_splitting.SINGLE + 2 * len(table.nodes), 0, len(table.dense),
            first + backward_splitting.LAM,
            first + backward_splitting.SCALE, functools.partial(stable_kicks, name),
            _memory, _blocks,
        )  # fmt: skip
    table = table_of(name)
    single = 4 * len(table.c)
    flat = table.n_stages, table.c, *table.rows, *table.columns, *table.seeded, *table[-2:]
    return Backward(
        flat, scalar.sweep_kernel, scalar.replay_kernel, table.n_rows, len(table.c), len(table.c),
        single + backward.LAM, single + backward.SCALE, functools.partial(stable_size, name),
        _memory, _blocks,
    )  # fmt: skip
