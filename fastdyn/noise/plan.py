"""The plan of a stochastic solve: functions compiled, the method chosen, the kernel found."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.target import width as lanes
from fastdyn.compile.bind import bind
from fastdyn.compile.derivatives.jacobian import jacobian
from fastdyn.compile.derivatives.vector_form import vector_form
from fastdyn.compile.mode import DERIVATIVE, EVENT
from fastdyn.compile.parameters import pack_all
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FIRST
from fastdyn.specialise.in_lanes import check_length
from fastdyn.specialise.noise import by_address, in_lanes
from fastdyn.trace.graph.jumps import decisions
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.words.near import did_you_mean

from .methods import METHODS


class NoisePlan(NamedTuple):
    """What the text of a kernel depends on, besides the functions.

    Parameters
    ----------
    method : methods.NoiseMethod
    n, n_drift, n_sources : int
        Components of the state and of the drift, sources of noise.
    diagonal, ito : bool
    n_columns : int
    terminal : tuple of bool
        For each event, whether a passage ends the path.
    """

    method: Any
    n: int
    n_drift: int
    n_sources: int
    diagonal: bool
    n_columns: int
    ito: bool
    terminal: tuple


class NoiseKernel(NamedTuple):
    """A kernel, the block that it takes, its lanes, and why it has one lane, if it has."""

    code: Any
    block: np.ndarray
    width: int
    reason: str
    bounds: list
    keepalive: list


class Bounds(NamedTuple):
    """The bound functions: drift, columns, events."""

    drift: Any
    columns: list
    events: list

    @property
    def all(self):
        return [self.drift, *self.columns, *self.events]


def bound_functions(equations, events, args, near, n):
    """The Bounds of all functions of (t, y, *args)."""

    def one(fun, mode, length):
        return bind(fun, args, mode, length, near._replace(y0=near.y0[:length]))

    drift = one(equations.drift, DERIVATIVE, equations.n)
    columns = [one(column, DERIVATIVE, equations.n) for column in equations.columns]
    return Bounds(drift, columns, [one(event, EVENT, n) for event in events])


def noise_of(equations, bounds, calculus):
    """The kind of the noise: "additive", "unmixed", "general"; None if nobody knows.

    Where a diffusion jumps with the state, its derivative tells neither that it depends on the
    state, nor how Stratonovich's integral differs from Ito's.
    """
    if equations.constant:
        return "additive"
    found = []
    jumps = False
    for bound in bounds.columns:
        try:
            known = jacobian(bound.function)
        except Untraceable:
            known = None
        if known is None:
            return None
        found.append(known)
        traced = bound.function.traced
        jumps = jumps or bool(decisions(traced.trace.graph, traced.stored, ()))
    depends = any(one.depends for one in found)
    if jumps and (not depends or calculus == "stratonovich"):
        return "general"
    if not depends:
        return "additive"
    if not equations.diagonal:
        return "unmixed" if len(found) == 1 else "general"
    return "unmixed" if np.array_equal(found[0].rows, found[0].columns) else "general"


class NoDerivative(ValueError):
    """A method needs the derivative of the diffusion, and there is no code for that."""


def method_for(name, calculus, noise, langevin=False, derivative=True):
    """The NoiseMethod of a name; "auto" takes the method of the highest order on paths.

    Without `derivative`, "auto" takes no method that needs the derivative of the diffusion.

    Raises
    ------
    ValueError
        If a method is unknown, or does not hold for the integral or the noise.
    """
    mine = {key: each for key, each in METHODS.items() if each.langevin == langevin}
    if name == "auto":
        fits = [each for each in mine.values() if not _misfit(each, calculus, noise)]
        fits = [each for each in fits if derivative or not each.derivative]
        return max(fits, key=lambda each: each.strong)
    if name not in mine:
        known = f"choose from auto, {', '.join(mine)}."
        meant = did_you_mean(name, mine, form='"{}"') or known
        raise ValueError(f"`method={name!r}` is unknown; {meant}")
    if reason := _misfit(mine[name], calculus, noise):
        raise ValueError(f"`method={name!r}` {reason}.")
    return mine[name]


def _misfit(method, calculus, noise):
    """Why a method does not hold; an empty text if it does."""
    if calculus not in method.integrals and noise != "additive":
        others = [m.name for m in METHODS.values() if calculus in m.integrals and not m.langevin]
        return f"does not hold for the {calculus} integral; choose from {', '.join(others)}"
    if method.noise == "any" or noise == "additive" or (method.noise == noise == "unmixed"):
        return ""
    if noise is None:
        return "asks for the derivative of `diffusion`, which is known of traced functions only"
    if method.noise == "additive":
        return "is for noise that does not depend on the state; `diffusion` does"
    return (
        "is for noise whose sources do not mix: `diffusion` has several columns, a component's "
        "noise depends on another component, or jumps with the state"
    )


def kernel_of(plan, equations, bounds, events, args, near):
    """The NoiseKernel: on vectors if all functions have a form on them, else one path at a time."""
    try:
        return _in_lanes(plan, equations, bounds, events, args, near)
    except Uncompilable as reason:
        if plan.method.derivative:
            others = '"EulerMaruyama" or "Platen"' if plan.ito else '"EulerHeun"'
            raise NoDerivative(
                f'`method="{plan.method.name}"` needs the derivative of `diffusion` on vectors: '
                f"{reason}. Choose {others}."
            ) from None
        code = by_address(plan)
        block = np.array([bound.block.ctypes.data for bound in bounds.all], np.int64)
        return NoiseKernel(code, block, 1, str(reason), bounds.all, [code, bounds])


def _in_lanes(plan, equations, bounds, events, args, near):
    check_length(max(plan.n, plan.n_sources))
    for bound in bounds.all:
        if bound.function is None or bound.function.traced is None:
            raise Uncompilable("a function cannot be traced")
    width = lanes()
    same = (False,) * len(args)
    functions = [(equations.drift, DERIVATIVE, equations.n)]
    functions += [(column, DERIVATIVE, equations.n) for column in equations.columns]
    functions += [(event, EVENT, plan.n) for event in events]
    forms = [
        vector_form(fun, args, same, mode, n, near._replace(y0=near.y0[:n]), width)
        for fun, mode, n in functions
    ]
    code = in_lanes(plan, forms, width)
    block = np.zeros(FIRST + sum(form.n_words for form in forms), np.int64)
    keepalive = [code, forms]
    pack_all([each for form in forms for each in form.parameters], block, keepalive)
    return NoiseKernel(code, block, width, "", bounds.all, keepalive)


def near_of(t0, tf, y0):
    return Near(t0, tf, np.array(y0))
