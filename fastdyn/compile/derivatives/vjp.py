"""Compiles the product of a row vector k and the Jacobians of the equations: k df/dy, k df/dp.

The product is called like the function, ``vjp(t, [y, k], 2 n, block, out)``, with the block of the
function.  It adds n numbers, k df/dy, and m numbers, k df/dp, to `out`: the second part is the
gradient, which the steps of a backward sweep sum.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import along
from fastdyn.trace.graph.expressions import MAX_NODES
from fastdyn.trace.graph.jumps import decisions
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.graph.reverse import pullback

from ..callables import Uncompilable
from ..functions import with_code
from ..mode import DERIVATIVE, ENTRIES, VJP, Mode
from ..python_callback import Held
from ..traced.known import Attempt
from ..traced.make import LONG, traced_function
from .jacobian import jacobian
from .sensitivities import DECISIONS, slots_of

NOT_TRACED = "it cannot be traced"
TOO_LONG = (
    f"it cannot be traced number by number, in at most {MAX_NODES} operations, as derivatives of "
    "long arrays must be"
)


class Product(NamedTuple):
    """The vjp of a function with the values of one solve.

    `bound` is a Bound of the vjp, `n` and `m` are the numbers of its results; `positions` are those
    of the differentiated arguments; `mode` is that of the function.  For methods that solve
    equations, `jacobian` is a Bound of the Jacobian, whose entries have `places`, (rows, columns).
    For a Rosenbrock method, df/dt follows the entries, and `along` is a Bound of the vjp of the
    derivative of the function along a vector.
    """

    bound: Any
    n: int
    m: int
    positions: tuple
    mode: Mode = DERIVATIVE
    jacobian: Any = None
    places: Any = None
    along: Any = None

    def with_values(self, values):
        """The Product with other outside values, (type, value) pairs."""

        def other(bound):
            return bound and frozen(bound.function, None, values, bound.mode, bound.n, bound.at)

        return self._replace(
            bound=other(self.bound), jacobian=other(self.jacobian), along=other(self.along)
        )


def bind_vjp(fun, args, near, positions, mode=DERIVATIVE, backward="stages"):
    """The Product of ``fun(t, y, *args)`` by y, and by the arguments at `positions`, from 1.

    For q'' = a(t, q), `near` has q, and so has the Product in place of y.  The
    Product has what a sweep of the kind `backward` needs: see `methods.method.Facts`.

    The Product keeps copies of all outside values: no later change of an array changes it.

    Raises
    ------
    Uncompilable
        If `fun` has no trace, or a derivative is missing.
    """
    n = len(near.y0)
    rosenbrock = backward == "rosenbrock"
    attempt = Attempt(fun, args, mode, n, sorted(positions))
    found = traced_function(attempt, near)
    if found is None:
        raise Uncompilable(attempt.why() or (NOT_TRACED if n < LONG else TOO_LONG))
    base, values, at = found
    groups = tuple([at[j - 1] for j in positions])
    try:
        function = base.derived((VJP, groups), lambda: _vjp(base, groups, n))
        second = rosenbrock and base.derived((VJP, 2, groups), lambda: _along(base, groups, n))
        solves = rosenbrock or backward == "collocation"
        entries: Any = solves and jacobian(base, time=rosenbrock)
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    m = function.traced.n_stored - n
    bound = frozen(function, None, values, VJP, 2 * n, at)
    product = Product(bound, n, m, tuple(positions), mode)
    if not solves:
        return product
    return product._replace(
        jacobian=frozen(entries.function, None, values, ENTRIES, n, at),
        places=(entries.rows, entries.columns),
        along=second and frozen(second, None, values, VJP, 3 * n + 1, at),
    )


def bind_direction(fun, args, near, positions, turns, mode=DERIVATIVE):
    """The Bound of y' = f and of s' = df/dy s + df/dp v, for a state of y, followed by s.

    v = a p + b for the parameters p at `positions` in turn, and the rows a and b of `turns`, which
    are part of the code.  Otherwise as `bind_vjp`.
    """
    n = len(near.y0)
    found = traced_function(Attempt(fun, args, mode, n, sorted(positions)), near)
    if found is None:
        raise Uncompilable(NOT_TRACED)
    base, values, at = found
    groups = tuple([at[j - 1] for j in positions])
    place = VJP, "direction", groups, turns.tobytes()
    try:
        function = base.derived(place, lambda: _direction(base, groups, n, turns))
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    return frozen(function, None, values, mode, 2 * n, at)


def _direction(base, groups, n, turns):
    traced = base.traced
    g = base.traced.trace.graph
    inputs, _ = _inputs(base, groups, n)
    moved = [(inputs[i], g.make("y", (), n + i)) for i in range(n)]
    for p, a, b in zip(inputs[n:], *turns.tolist(), strict=True):
        moved.append((p, g.add(g.mul(g.const(a), p), g.const(b))))
    outputs = [*traced.stored, *along(g, traced.stored, moved)]
    return traced.with_outputs(outputs, traced.mode, 2 * n).compiled()


def frozen(function, python, values, mode, n, at=()):
    """A Bound with copies of its (type, value) pairs."""
    copies = [(kind, np.array(v) if isinstance(v, np.ndarray) else v) for kind, v in values]
    return with_code(function, python, Held(), copies, mode, n, at)


def _along(base, groups, n):
    """The vjp, at (t, [y, k, u, s]), of the derivative of a function along (u, s), s in time."""
    traced = base.traced
    g = base.traced.trace.graph
    inputs, _ = _inputs(base, groups, n)
    moved = [(inputs[i], g.make("y", (), 2 * n + i)) for i in range(n)]
    moved.append((g.make("t"), g.make("y", (), 3 * n)))
    derivative = along(g, traced.stored, moved)
    k = [g.make("y", (), n + i) for i in range(n)]
    entries = []
    outputs = pullback(g, derivative, k, inputs, entries)
    return traced.with_outputs(outputs, VJP, 3 * n + 1, g.false, entries).compiled()


def _inputs(base, groups, n):
    """The nodes of the state and of the differentiated parameters; the slots of the latter."""
    g = base.traced.trace.graph
    slots = [slot for group in groups for slot in slots_of(base.traced.trace.reads, group, n)]
    inputs = [g.make("y", (), i) for i in range(n)]
    return inputs + [g.make("par", (), slot) for slot in slots], slots


def _vjp(base, groups, n):
    traced = base.traced
    g = base.traced.trace.graph
    cotangents = [g.make("y", (), n + i) for i in range(n)]
    inputs, slots = _inputs(base, groups, n)
    entries = []
    outputs = pullback(g, traced.stored, cotangents, inputs, entries)
    function = traced.with_outputs(outputs, VJP, 2 * n, g.false, entries).compiled()
    own = traced.trace._replace(outputs=traced.stored)
    function.notes[DECISIONS] = own, decisions(own.graph, own.outputs, set(slots))
    return function
