"""A method for tests: Taylor series of linear autonomous equations, y[k+1] = f(y[k]) / (k + 1).

Its steps are constant and as long as one likes; its rows are those of `kernels/state/series.py`,
but for the order.  Events may have series, which are written here by hand.
"""

import functools
import hashlib
from pathlib import Path

import numpy as np

from fastdyn import code_store
from fastdyn.kernels.jit.options import INTERNAL, njit
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods.method import Facts, method
from fastdyn.kernels.output.arguments import MOST_ROOTS, SERIES
from fastdyn.kernels.state.record import FINISHED, RUNNING, Y_OLD, K, Y
from fastdyn.kernels.state.rows import slot
from fastdyn.kernels.stepping.first_step import plain
from fastdyn.problem import validate
from fastdyn.run import laid_out
from fastdyn.specialise.scalar import all_roots_kernel
from fastdyn.specialise.signatures import ROW, TABLE, kernel_of

ORDER = 33
SCALE = K + ORDER + 2
NAME = f"Series {hashlib.sha256(Path(__file__).read_bytes()).hexdigest()}"  # kept code has this key


def kernel(rhs, form):
    """The loop: at most `n_steps` steps of state.h, the last of which ends at t_end or beyond."""

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps):
        s, taken = state[0], 0
        work[SCALE] = 1.0
        while taken < n_steps and s.direction * (s.t_end - s.t) > 0.0:
            for i in range(work.shape[1]):
                work[Y_OLD, i] = work[K, i] = work[Y, i]
            for k in range(ORDER):
                rhs(s.t, slot(None, work, K + k), block, slot(None, work, K + k + 1))
                for i in range(work.shape[1]):
                    work[K + k + 1, i] /= k + 1.0
            for i in range(work.shape[1]):
                total = 0.0
                for k in range(ORDER, -1, -1):
                    total = total * (s.direction * s.h) + work[K + k, i]
                work[Y, i] = total
            s.t_old = s.t
            s.t += s.direction * s.h
            s.n_accepted += 1
            taken += 1
        return FINISHED if s.direction * (s.t_end - s.t) <= 0.0 else RUNNING

    return loop


@njit(**INTERNAL)
def dense_rows(rhs, t, h, work, block, d):
    """The rows of the interpolant from the coefficients: divide by x and by 1 - x in turn."""
    for i in range(work.shape[1]):
        power = 1.0
        for k in range(ORDER + 1):
            d[k, i] = power * work[K + k, i]
            power *= h
        for j in range(1, ORDER):
            if j % 2 == 1:  # what is left by 1 - x; its value at 1
                for k in range(ORDER - 1, j - 1, -1):
                    d[k, i] += d[k + 1, i]
                for k in range(j + 1, ORDER + 1):
                    d[k, i] = -d[k, i]
    return 0


METHOD = method(
    NAME, order=ORDER, error_order=0, n_stages=ORDER, n_rows=ORDER + 3, fsal_stage=1, kernel=kernel,
    start=plain, n_dense=ORDER, dense_rows=dense_rows, dense_order=ORDER,
)  # fmt: skip


class Stands(Facts):
    """The facts of a method whose code is here."""

    code = METHOD
    events_at_once = MOST_ROOTS


FACTS = Stands(*METHOD.facts)


def install(monkeypatch):
    """Let the method be known, and events that have an attribute `series` be found by it."""
    monkeypatch.setattr(BY_NAME, "maps", [*BY_NAME.maps, {NAME: FACTS}])
    monkeypatch.setattr(validate, "METHODS", {**validate.METHODS, NAME: FACTS})
    without = laid_out.event_table

    def event_table(problem, others):
        table = without(problem, others)
        for row, event in zip(table, problem.events, strict=True):
            if problem.method.name != NAME:
                continue
            row["series"] = getattr(event.function, "series", 0)
            row["find"] = all_roots_kernel().address
            row["middle"] = SERIES
        return table

    monkeypatch.setattr(laid_out, "event_table", event_table)


@functools.cache
def series_of(weights, constant=0.0, n_terms=ORDER + 1):
    """The address of the series of weights . y + constant."""
    weights = np.array(weights)

    @njit(**INTERNAL)
    def series(t_old, h, work, block, out):
        power = 1.0
        for k in range(n_terms):
            total = 0.0
            for i in range(len(weights)):
                total += weights[i] * work[K + k, i]
            out[k] = power * total
            power *= h
        out[0] += constant
        return n_terms

    signature = kernel_of(0.0, 0.0, TABLE, 0, ROW)
    code = code_store.compiled(None, lambda: (series, signature))
    KEPT.append(code)
    return code.address


KEPT = []
