"""The structure of equations of motion that a method may need, checked and bound.

Equations q'' = a(t, q) are one function of the whole state, whose result is checked.  A separable
Hamiltonian H = T(p) + V(q) is a Pair of functions.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile import memory
from fastdyn.compile.bind import bind
from fastdyn.compile.derivatives.sensitivities import bind_variational
from fastdyn.compile.functions import Bound, Function
from fastdyn.compile.mode import ACCELERATION, COLUMN, DERIVATIVE, FORCE, VELOCITY
from fastdyn.compile.python_callback import Held, called_with, derivative, evaluate
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls import block as words
from fastdyn.kernels.calls.block import FAULT, WORDS_OF_PAIR
from fastdyn.kernels.methods import METHODS
from fastdyn.specialise.scalar import both_of_pair
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace
from fastdyn.trace.reads.program import reader

from .lsoda import NO_BAND
from .sensitivities import Variational

HALVES = (VELOCITY, FORCE)
IMPLICIT_FROM = 500  # components, from which on implicit methods take long arrays
_together = memory.Table()  # two compiled functions as one


class Pair(NamedTuple):
    """q' = velocity(t, p), p' = force(t, q); called as one function of the state [q, p]."""

    velocity: Any
    force: Any

    def __call__(self, t, y, *args):
        q, p = np.split(np.asarray(y), 2)
        given = zip(self, HALVES, (p, q), strict=True)
        return np.concatenate([evaluate(called_with(f, args), mode, t, x) for f, mode, x in given])


def pair_of(functions):
    """A Pair of two functions; TypeError for anything else."""
    if len(functions) != 2 or not all(map(callable, functions)):
        raise TypeError(f"give two functions, `velocity` and `force`; got {functions!r}.")
    return Pair(*functions)


def check_pair(n, method):
    """Refuse a state that is not [q, p], and methods that are not for T(p) + V(q)."""
    if n % 2:
        raise ValueError(f"the state [q, p] has an even number of components; got {n}.")
    if method.second_order and not method.separable:
        known = [name for name, m in METHODS.items() if m.separable or not m.second_order]
        raise ValueError(
            f"{method.name} is a Nystrom method, made for q'' = a(t, q): for T quadratic in p. "
            f"For H = T(p) + V(q) choose from {', '.join(known)}."
        )


def check_second_order(fun, t0, y0, args, name):
    """Refuse a system that is not q' = v, v' = a(t, q)."""
    if len(y0) % 2:
        raise ValueError(f"{name} takes a state [q, v]; got {len(y0)} components.")
    m = len(y0) // 2
    probe = y0.copy()
    probe[m:] += 1.0 + np.arange(m)
    first, second = (derivative(fun(t0, y.copy(), *args), 2 * m) for y in (y0, probe))
    if not (np.array_equal(first[:m], y0[m:]) and np.array_equal(second[:m], probe[m:])):
        raise ValueError(
            f"{name} takes y = [q, v] with q' = v, and the first half of what `fun` "
            "returns is not v; order the state as positions, then velocities, or take Gauss16."
        )
    if not np.array_equal(first[m:], second[m:], equal_nan=True):
        raise ValueError(
            f"{name} takes q'' = a(t, q), and the acceleration that `fun` returns depends "
            "on the velocity; take Gauss16, RK45 or DOP853."
        )


def is_second_order(found, n):
    """Whether the Trace of a function of n components has q' = v, v' = a(t, q) for all values."""
    m = n // 2
    rates = [(one.op, one.data) for one in found.outputs[:m]]
    if n % 2 or rates != [("y", m + i) for i in range(m)]:
        return False
    used = live([*found.outputs[m:], found.raising])
    return not any(one.op == "y" and one.data >= m for one in used)


def form_reader(fun, args, n):
    """``read(fun, args)``, None if a function may not be q' = v, v' = a(t, q), like the given one.

    None if the graph of the function of n components does not show the form.
    """
    try:
        found = trace(fun, args, n, (n,))
    except Untraceable:
        return None
    found.reads.close()
    return reader(found.reads) if found.reads.lasting and is_second_order(found, n) else None


def mode_for(asked, method):
    """The mode of the equations of Arguments, with a real state, for a method.

    For a method for q'' = a(t, q), the equations are checked to have this form.
    """
    if not method.second_order:
        return COLUMN if asked.vectorized else DERIVATIVE
    check_second_order(asked.fun, asked.t0, asked.y0, asked.args, method.name)
    return ACCELERATION


def given_state(problem):
    """The argument y of the equations at the start: y0, or the positions alone."""
    p = problem
    alone = p.method.second_order and not isinstance(p.fun, Pair)
    return p.y0[: len(p.y0) // 2] if alone else p.y0


def probe_equations(problem):
    """Evaluate the equations once in Python, to report mistakes."""
    p = problem
    evaluate(called_with(p.fun, p.args), p.mode, p.t0, given_state(p).copy())


def takes_batches(problem):
    """True if the pointer form of the equations suffices for a solve.

    Implicit methods then take differences for the Jacobian, where it may differ from zero.
    """
    p = problem
    short = len(p.y0) < IMPLICIT_FROM or p.mode.complex_numbers
    if p.method.n_matrices and (short or p.band != NO_BAND):
        return False
    return not p.method.series


def bind_equations(problem):
    """The Bound of the equations of a problem."""
    p = problem
    y0 = given_state(p)
    if isinstance(p.fun, Variational):
        return bind_variational(p.fun, p.args, Near(p.t0, p.tf, p.fun.own(y0)))
    if not isinstance(p.fun, Pair):
        near = Near(p.t0, p.tf, y0, takes_batches(p))
        return bind(p.fun, p.args, p.mode, len(y0), near)
    q, v = np.split(y0, 2)
    pair = tuple(
        [
            bind(fun, p.args, mode, len(x), Near(p.t0, p.tf, x))
            for fun, mode, x in zip(p.fun, HALVES, (v, q), strict=True)
        ]
    )
    block = np.zeros(WORDS_OF_PAIR, np.int64)
    block[0] = both_of_pair().address
    block[FAULT] = WORDS_OF_PAIR
    for word, part in zip((words.VELOCITY, words.FORCE), pair, strict=True):
        block[word] = part.block.ctypes.data
    return Bound(
        _function_of([part.function for part in pair]), block,
        lambda t, y: p.fun(t, y, *p.args), Held(p.fun, p.args), None, [], p.mode, pair,
    )  # fmt: skip


def _function_of(functions):
    """Two compiled functions as one; None if one of them stays in Python."""
    if None in functions:
        return None
    return _together.get(tuple(functions)) or _together.put(tuple(functions), _one(functions))


def _one(functions):
    return Function(
        " and ".join([f.key for f in functions]),
        tuple([f.address for f in functions]),
        0,
        lambda: tuple([f.build() for f in functions]),
        functions,
        seconds=sum([f.seconds for f in functions]),
    )
