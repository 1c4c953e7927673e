"""Compares the code of derivatives with differences of the function, at states of a solution.

The derivative along one vector is compared; the components of the vector are random, so that each
element of the Jacobian contributes.  States and times are moved away from kinks, because a kink has
several derivatives.  The differences have several step lengths, because a function may oscillate
within a step.
"""

import numpy as np

from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.reads.reads import flat

from ..compare import Different, agree, called, machine_value, python_value
from ..function_convention import call, code_at
from ..python_callback import evaluate as evaluated
from .sensitivities import DECISIONS

APART = 1e-2  # relative deviation beyond the errors of differences
EPS = np.finfo(float).eps
NOISE = 1e3 * EPS  # rounding of a difference, relative to its terms
HIDDEN = 10 * EPS  # rounding of a function, relative to the largest number in its evaluation
STEPS = EPS ** (1 / 3) * np.array([1.0, 0.1, 0.01])
# The share of a component, and of the span, by which a state and a time are moved from a kink on
# which they may lie; steps end at the knots of tables.
ASIDE = 1e-3
TINY = np.finfo(float).tiny
SMALLEST = 1e-4  # least size of a component, as a share of its largest size along the solution
MOST, FEWEST = 3, 2  # number of compared states; least number of states that must differ


class OtherDerivative(Different):
    """The code of a derivative is not the derivative of its function."""

    sentence = "its compiled derivative along a vector is {}, and differences give {}"


def compare_jacobian(bound, times, states):
    """Raise OtherDerivative if the Jacobian made for a Bound is not the derivative of the Bound."""
    for time in (False, True):
        found = bound.function.notes.get(("jacobian", time))
        if found is not None:
            _compare(bound, times, states, lambda *at, found=found: _along(bound, found, *at))


def compare_sensitivities(bound, equations, args, times, states):
    """Raise OtherDerivative if S' of the sensitivities S contradicts differences of `fun`.

    Parameters
    ----------
    bound : Bound
        The compiled variational equations.
    equations : problem.sensitivities.Variational
    args : tuple
    times, states : sequences
        The states include the sensitivities; of q'' = a(t, q), their first halves are compared.
        Those of a residual include y' and S', and the residual of S is compared.
    """
    states = [each[: bound.n] for each in states]
    _compare(bound, times, states, lambda *at: _of_solution(bound, equations, args, *at))


def compare_vjp(product, fun, args, times, states):
    """Raise OtherDerivative if k J of a `vjp.Product` contradicts differences of ``fun(t, y)``."""
    states = [each[: product.n] for each in states]
    _compare(product.bound, times, states, lambda *at: _of_product(product, fun, args, *at))


@np.errstate(all="ignore")
def _compare(bound, times, states, derivative):
    """Raise OtherDerivative if the derivative is wrong at most of a few states.

    ``derivative(t, y, sizes, span, rng)`` returns a derivative along a vector, the sum of the
    absolute values of its terms, and the function along the vector, ``at(distance)``.  Or it
    returns None: the state is left out.
    """
    rng = np.random.default_rng(1)
    wrong = []
    tried = 0
    largest = np.abs(states).max(axis=0) if len(states) else 0.0
    span = times[-1] - times[0] if len(times) else 0.0
    for i in np.unique(np.linspace(0, len(times) - 1, MOST).astype(int)) if len(times) else ():
        inwards = ASIDE * span if i < len(times) - 1 else -ASIDE * span
        t = times[i] + inwards * rng.uniform(0.1, 1.0)
        y = np.array(states[i])
        found = derivative(t, y, np.maximum(np.abs(y), SMALLEST * largest), abs(span), rng)
        if found is None:
            continue
        tried += 1
        differences = _contradicted(*found)
        if differences is not None:  # costly, so only if the first test fails
            differences = _contradicted(*found, largest=_largest(bound, t, y, found[0]))
        if differences is not None:
            wrong.append((t, y, differences, found[0]))
    if len(wrong) >= FEWEST and 2 * len(wrong) > tried:
        raise OtherDerivative(bound, *wrong[0])


def _along(bound, jacobian, t, y, sizes, span, rng):
    """The `derivative` of `_compare` for a Jacobian, with df/dt if the Jacobian has df/dt."""
    n = len(y)
    y = y + ASIDE * sizes * rng.uniform(-1.0, 1.0, n)
    v = sizes * rng.uniform(0.1, 1.0, n)
    span = jacobian.time * ASIDE * span
    found = called(bound, jacobian.function, jacobian.size, t, y)[0]
    terms = found[: len(jacobian.rows)] * v[jacobian.columns]
    along = np.bincount(jacobian.rows, terms, n)
    total = np.bincount(jacobian.rows, np.abs(terms), n)
    if jacobian.time:
        along = along + span * found[-n:]
        total = total + span * np.abs(found[-n:])
    return along, total, lambda h: machine_value(bound, t + h * span, y + h * v)


def _of_solution(bound, equations, args, t, z, sizes, span, rng):
    """The `derivative` of `_compare` for variational equations; None if the function raises.

    The vector moves the initial state and the parameters.  No parameter, and no component of the
    state, moves by more than its size.
    """
    n = equations.n
    m = equations.n_directions
    own, columns = equations.parts(z)
    sizes, _ = equations.parts(sizes)
    own = own + ASIDE * sizes * rng.uniform(-1.0, 1.0, len(own))
    z = equations.joined(own, columns)
    real = python_value(bound, t, z)
    rates = machine_value(bound, t, z)
    if isinstance(real, Exception) or rates is None:
        return None
    if not agree(bound, real, np.concatenate([rates[:n], real[n:]]), t, z):
        raise Different(bound, t, z[:n], real[:n], rates[:n])
    slopes = rates[n : n + n * m].reshape(n, m)
    most = np.where(columns == 0.0, np.inf, sizes[:, None] / np.abs(columns)).min(axis=0)
    w = np.minimum(most, _sizes(equations.directions, equations.n_start, args)) * rng.uniform(
        0.1, 1.0, m
    )
    w[~np.isfinite(w)] = 0.0

    def at(h):
        moved = equations.joined(own + h * (columns @ w), columns)
        try:
            with equations.varied(args, h * w):
                return equations(
                    t, moved, *_moved(equations.directions, equations.n_start, args, h * w)
                )[:n]
        except Exception:
            return None

    return slopes @ w, np.abs(slopes) @ w, at


def _of_product(product, fun, args, t, y, sizes, span, rng):
    """The `derivative` of `_compare` for k J v, with random k and v."""
    n = len(y)
    y = y + ASIDE * sizes * rng.uniform(-1.0, 1.0, n)
    k = rng.uniform(0.1, 1.0, n) * rng.choice([-1.0, 1.0], n)
    try:
        rates = evaluated(_with(fun, args), product.mode, t, y.copy())
    except Exception:
        return None
    k /= np.maximum(np.abs(rates), SMALLEST * np.abs(rates).max()) + TINY
    w = _sizes(product.positions, n, args) * rng.uniform(0.1, 1.0, product.m)
    v = np.concatenate([sizes * rng.uniform(0.1, 1.0, n), w])
    found = np.zeros(n + product.m)
    function = code_at(product.bound.function.address)
    call(function, t, np.concatenate([y, k]), product.bound.block, found)
    terms = found * v

    def at(h):
        moved = _moved(product.positions, n, args, h * w)
        try:
            return np.array([k @ evaluated(_with(fun, moved), product.mode, t, y + h * v[:n])])
        except Exception:
            return None

    return np.array([terms.sum()]), np.array([np.abs(terms).sum()]), at


def _with(fun, args):
    return lambda t, y: fun(t, y, *args)


def _sizes(positions, n, args):
    """The size of the parameter of each direction; inf for a component of the initial state."""
    found = []
    for position in positions:
        value = np.abs(args[position - 1]).ravel() if position else np.full(n, np.inf)
        found.append(np.where(value == 0.0, 1.0, value))
    return np.concatenate(found) if found else np.empty(0)


def _moved(positions, n, args, steps):
    """The arguments, moved along the directions; initial states are no arguments."""
    args = list(args)
    at = 0
    for position in positions:
        size = np.size(args[position - 1]) if position else n
        if position:
            value = args[position - 1]
            args[position - 1] = value + steps[at : at + size].reshape(np.shape(value))[()]
        at += size
    return args


def _largest(bound, t, y, results):
    """The size of the largest number that the function computes for its results."""
    function = bound.function
    own = function.notes[DECISIONS][0].outputs if DECISIONS in function.notes else None
    nodes = live(own or function.traced.stored[: len(results)])
    nodes = [node for node in nodes if not OPERATIONS[node.op].inner]
    graph = function.traced.trace.graph
    values = flat([value for _, value in bound.values])
    found = evaluate(graph, [], np.array([t]), y[:, None], values, nodes)[1]
    sizes = np.abs(np.asarray(found, float))
    return float(sizes[np.isfinite(sizes)].max(initial=0.0))


def _contradicted(along, total, at, largest=0.0):
    """The differences of a function if they contradict a derivative at each step; else None.

    `largest` is the largest number in the evaluation of the function.
    """
    wrong = np.isfinite(along)
    near = along
    for step in STEPS:
        near, noise = _difference(at, step)
        far, _ = _difference(at, 4 * step)
        noise = noise + HIDDEN * largest / step
        doubt = 10 * np.abs(near - far) + noise + APART * np.maximum(total, np.abs(near))
        wrong &= np.abs(along - near) > doubt
        if not wrong.any():
            return None
    return near


def _difference(at, step):
    """(A central difference, a bound of its rounding error); nan if the function raises."""
    above = at(step)
    below = at(-step)
    if above is None or below is None:
        return np.nan, np.nan
    return (above - below) / (2 * step), NOISE * (np.abs(above) + np.abs(below)) / (2 * step)
