"""`solve_ivp` for PyTorch: autograd in both directions through a compiled solve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.plot.needed import needed
from fastdyn.solve.differentiable import Library, Solution, call_of

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Function, Functions, Method, Times, TimeSpan

torch = needed("torch", "fastdyn.torch needs")

__all__ = ["Solution", "solve_ivp"]

TWICE = (
    "fastdyn.torch.solve_ivp is differentiated once: second derivatives are not available.  Take "
    "differences of gradients."
)

TORCH = Library(
    "torch",
    lambda value: isinstance(value, torch.Tensor),
    lambda value: value.requires_grad or _has_tangent(value),
    lambda value: str(value.dtype).removeprefix("torch."),
    lambda values: torch.stack([torch.as_tensor(value, dtype=torch.float64) for value in values]),
    lambda value: value.shape,
    "convert it by .double(), or make it with dtype=torch.float64.",
)


def solve_ivp(
    fun: Function,
    t_span: TimeSpan,
    y0: Any,
    method: Method = "RK45",
    t_eval: Times | None = None,
    events: Functions | None = None,
    args: tuple = (),
    *,
    occurrences: int = 1,
    **options: Any,
) -> Solution:
    """Solve ``y' = fun(t, y, *args)`` as a function of tensors.

    Parameters
    ----------
    fun, t_span, method, events
        As in `fastdyn.solve_ivp`: `fun` is written with NumPy, and compiled by fastdyn.
    y0 : array_like, shape (n,)
        Initial state; a tensor of float64, or a sequence with such numbers, may vary.
    t_eval : array_like, optional
        Times of output; by default the end of the span alone.
    args : tuple
        Arguments of `fun` and of the events.  Tensors of float64 may vary; all else is fixed.
    occurrences : int
        The number of occurrences of each event that are returned.
    **options
        Tolerances and other options of `fastdyn.solve_ivp`, fixed.

    Returns
    -------
    Solution
        A NamedTuple of tensors on the processor: `t`, `y` of shape (n, n_points), `t_events`,
        `y_events`, `status`.  Times of events are differentiated, too, and the states there as they
        move.  What a run does not reach is nan, as is all of a run that fails.

    Raises
    ------
    TypeError, ValueError
        For float32 and integers that should vary, for tensors that `fun` takes from outside of
        `args`, and as `fastdyn.solve_ivp`.

    Notes
    -----
    Derivatives are those of `sensitivity`; those by more than eight numbers in reverse are those of
    `adjoint`, where it covers the problem.  They are of first order.
    """
    call, tensors = call_of(
        TORCH, fun, t_span, y0, method, t_eval, events, args, occurrences, options
    )
    *arrays, status = _Solve.apply(call, *tensors)
    return call.shapes.solution(torch.from_numpy(call.fixed.t_eval.astype(float)), arrays, status)


def _has_tangent(tensor):
    return torch.autograd.forward_ad.unpack_dual(tensor).tangent is not None


class _Solve(torch.autograd.Function):
    """The outputs of a Call, as a function of its values."""

    @staticmethod
    def forward(ctx, call, *tensors):
        values = [_host(tensor) for tensor in tensors]
        ctx.save_for_backward(*tensors)
        ctx.call, ctx.values, ctx.back = call, values, None
        ctx.wanted = tuple([i for i, needs in enumerate(ctx.needs_input_grad[1:]) if needs])
        if ctx.wanted:
            ctx.back = call.backward(values, ctx.wanted)
            arrays, status = ctx.back.outputs, ctx.back.status
        else:
            arrays, status = call.solve(values)
        status = torch.tensor(status)
        ctx.mark_non_differentiable(status)
        return *[_tensor(array) for array in arrays], status

    @staticmethod
    def backward(ctx, *g):
        found: list = [None] * (1 + len(ctx.values))
        by_wanted = _Pull.apply(ctx.back, ctx.wanted, *ctx.saved_tensors, *g[:-1])
        for i, each in zip(ctx.wanted, by_wanted, strict=True):
            found[1 + i] = each
        return tuple(found)

    @staticmethod
    def jvp(ctx, _, *tangents):
        wanted = tuple([i for i, tangent in enumerate(tangents) if tangent is not None])
        slopes = ctx.call.forward(ctx.values, wanted)
        moved = slopes.push(wanted, [_host(tangents[i]) for i in wanted])
        return *[_tensor(each) for each in moved], None


class _Pull(torch.autograd.Function):
    """The derivatives by the wanted values, from the values and the derivatives by the outputs."""

    @staticmethod
    def forward(ctx, back, wanted, *tensors):
        n = len(tensors) - len(back.outputs)
        found = back.pull([_host(each) for each in tensors[n:]])
        pairs = zip(wanted, found, strict=True)
        return tuple([_tensor(each).to(tensors[i].device) for i, each in pairs])

    @staticmethod
    def backward(ctx, *g):
        raise NotImplementedError(TWICE)


def _host(tensor):
    return tensor.detach().cpu().numpy()


def _tensor(array):
    return torch.from_numpy(np.array(array))
