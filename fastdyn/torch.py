"""`solve_ivp` for PyTorch: autograd in both directions through a compiled solve."""

from __future__ import annotations

import numpy as np

from fastdyn.plot.needed import needed
from fastdyn.solve.differentiable import Library, Solution, door

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


def _solution(call, tensors):
    *arrays, status = _Solve.apply(call, *tensors)
    return call.shapes.solution(torch.from_numpy(call.fixed.t_eval.astype(float)), arrays, status)


solve_ivp = door(
    __name__, TORCH, _solution, arrays="tensors", array="a tensor", place=" on the processor"
)


def _has_tangent(tensor):
    return torch.autograd.forward_ad.unpack_dual(tensor).tangent is not None


class _Solve(torch.autograd.Function):
    """The outputs of a Call, as a function of its values."""

    @staticmethod
    def forward(ctx, call, *tensors):
        values = [_host(tensor) for tensor in tensors]
        ctx.save_for_backward(*tensors)
        ctx.call = call
        ctx.values = values
        ctx.back = None
        ctx.wanted = tuple([i for i, needs in enumerate(ctx.needs_input_grad[1:]) if needs])
        if ctx.wanted:
            ctx.back = call.backward(values, ctx.wanted)
            arrays = ctx.back.outputs
            status = ctx.back.status
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
