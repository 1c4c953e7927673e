"""`solve_ivp` for JAX: under jit, grad, jvp, vmap and their combinations.

Each of the three functions of a solve - its outputs, their derivatives along tangents, and the
derivatives of a number back to the arguments - is a primitive of JAX with a callback, so that both
directions of differentiation work, and vmap is an ensemble.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble
from fastdyn.plot.needed import needed
from fastdyn.solve.differentiable import (
    Axis,
    Library,
    Solution,
    door,
    pulled,
    pushed,
    sloped,
    solved,
)  # fmt: skip

jax = needed("jax", "fastdyn.jax needs")
jnp = needed("jax.numpy")
ad, batching, mlir = [needed(f"jax.interpreters.{name}") for name in ("ad", "batching", "mlir")]
core = needed("jax.extend.core")

__all__ = ["Solution", "solve_ivp"]

SWITCH = "jax.config.update('jax_enable_x64', True)"
TWICE = (
    "fastdyn.jax.solve_ivp is differentiated once: second derivatives, by jax.hessian or grad of "
    "grad, are not available.  Take differences of gradients."
)
JAX = Library(
    "JAX",
    lambda value: isinstance(value, jax.Array),
    lambda value: isinstance(value, jax.core.Tracer),
    lambda value: value.dtype.name,
    lambda values: jnp.stack([jnp.asarray(value) for value in values]),
    lambda value: value.shape,
    f"give numbers with a point, and switch float64 on before all else: {SWITCH}.",
)


def _ready():
    if jnp.zeros(()).dtype != float:
        raise ValueError(f"fastdyn computes in float64, which JAX has not switched on: {SWITCH}.")


def _solution(call, values):
    found = SOLVE.bind(*values, call=call, axis=Axis(None, (False,) * len(values)))
    status = jax.lax.stop_gradient(found[-1]).astype(int)
    return call.shapes.solution(jnp.asarray(call.fixed.t_eval), found[:-1], status)


solve_ivp = door(
    __name__, JAX, _solution, _ready, arrays="JAX arrays", array="a JAX array",
    more="  Under vmap, values are\nthose of `fastdyn.solve_ensemble`, and so are derivatives by "
    "numbers and initial states.",
)  # fmt: skip


def _primitive(name, shapes, host):
    """A primitive of operands with an Axis, whose results have `shapes` behind the axis.

    `host` computes the results from NumPy's arrays.  In compiled code all operands go through one
    array, and all results, since each array that passes between JAX and Python costs as much as a
    solve.
    """
    made = core.Primitive(f"fastdyn_{name}")
    made.multiple_results = True

    def whole(how):
        size = how["axis"].size
        return [shape if size is None else (size, *shape) for shape in shapes(**how)]

    def at_once(*operands, **how):
        found = host([np.asarray(each) for each in operands], **how)
        return [jnp.asarray(x, float) for x in found]

    def lowered(*operands, **how):
        given, wanted = [each.shape for each in operands], whole(how)

        def called(flat):
            return np.concatenate(
                [np.ravel(x) for x in host(_parts(np.asarray(flat), given), **how)]
            )

        size = sum([math.prod(shape) for shape in wanted])
        flat = jnp.concatenate([jnp.ravel(each) for each in operands] or [jnp.zeros(0)])
        return _parts(jax.pure_callback(called, jax.ShapeDtypeStruct((size,), float), flat), wanted)

    made.def_impl(at_once)
    made.def_abstract_eval(
        lambda *operands, **how: [jax.core.ShapedArray(s, np.dtype(float)) for s in whole(how)]
    )
    mlir.register_lowering(made, mlir.lower_fun(lowered, multiple_results=True))
    batching.primitive_batchers[made] = functools.partial(_batched, made)
    return made


def _parts(flat, shapes, lead=0):
    """The arrays of given shapes that lie in the last axis of one; the first `lead` are axes."""
    found = []
    begin = 0
    for shape in shapes:
        end = begin + math.prod(shape[lead:])
        found.append(flat[..., begin:end].reshape(shape))
        begin = end
    return found


def _batched(primitive, operands, places, *, axis, **how):
    """Bind a primitive to operands with one axis more, which joins an axis that is there."""
    counts = [place is not None for place in places]
    pairs = list(zip(operands, places, counts, strict=True))
    new = next(x.shape[place] for x, place, own in pairs if own)
    fronted = [jnp.moveaxis(x, place, 0) if own else x for x, place, own in pairs]
    size = axis.size
    if size is None:
        found = primitive.bind(*fronted, axis=Axis(new, tuple(counts)), **how)
        return found, [0] * len(found)
    joined = []
    for x, own, inner in zip(fronted, counts, axis.of, strict=True):
        if own or inner:
            x = x if own else jnp.broadcast_to(x, (new, *x.shape))
            x = x if inner else jnp.broadcast_to(x[:, None], (new, size, *x.shape[1:]))
            x = x.reshape(new * size, *x.shape[2:])
        joined.append(x)
    of = tuple([own or inner for own, inner in zip(counts, axis.of, strict=True)])
    found = primitive.bind(*joined, axis=Axis(new * size, of), **how)
    return [x.reshape(new, size, *x.shape[1:]) for x in found], [0] * len(found)


SOLVE = _primitive(
    "solve",
    lambda call, axis: [*call.shapes.arrays(), ()],
    lambda values, call, axis: solved(call, values, axis, solve_ensemble),
)
SLOPES = _primitive(
    "slopes",
    lambda call, wanted, axis: [*call.shapes.arrays(), (), (call.shapes.size, call.size(wanted))],
    lambda values, call, wanted, axis: sloped(call, wanted, values, axis, solve_ensemble),
)
PUSH = _primitive(
    "push",
    lambda call, wanted, axis: call.shapes.arrays(),
    lambda operands, call, wanted, axis: pushed(call, wanted, operands, axis),
)
PULL = _primitive(
    "pull",
    lambda call, wanted, axis: [call.inputs[i] for i in wanted],
    lambda operands, call, wanted, axis: pulled(call, wanted, operands, axis),
)


def _solve_jvp(values, tangents, *, call, axis):
    wanted = tuple([i for i, along in enumerate(tangents) if not isinstance(along, ad.Zero)])
    along = [jnp.asarray(tangents[i]) for i in wanted]
    if call.are_few(wanted):
        *found, slopes = SLOPES.bind(*values, call=call, wanted=wanted, axis=axis)
        moved = _applied(call, slopes, along, [axis.of[i] for i in wanted], axis.size)
    else:
        found = SOLVE.bind(*values, call=call, axis=axis)
        of = Axis(axis.size, axis.of + tuple([axis.of[i] for i in wanted]))
        moved = PUSH.bind(*values, *along, call=call, wanted=wanted, axis=of)
    return found, [*moved, jnp.zeros_like(found[-1])]


def _applied(call, slopes, along, counts, size):
    """The derivatives of the outputs along tangents, from one matrix of slopes."""
    lead = () if size is None else (size,)
    rows = []
    for each, own in zip(along, counts, strict=True):
        each = each if own or size is None else jnp.broadcast_to(each, (size, *each.shape))
        rows.append(each.reshape(*lead, -1))
    row = jnp.concatenate(rows, axis=-1) if rows else jnp.zeros((*lead, 0))
    flat = APPLY.bind(slopes, row)
    return _parts(flat, [(*lead, *shape) for shape in call.shapes.arrays()], len(lead))


def _refuse_twice(*operands, **how):
    raise NotImplementedError(TWICE)


def _linear_jvp(primitive):
    """The rule of a primitive that is linear in the operands behind the values."""

    def rule(operands, tangents, *, call, **how):
        n = len(call.inputs)
        if any(not isinstance(along, ad.Zero) for along in tangents[:n]):
            raise NotImplementedError(TWICE)
        found = primitive.bind(*operands, call=call, **how)
        along = [ad.instantiate_zeros(each) for each in tangents[n:]]
        return found, primitive.bind(*operands[:n], *along, call=call, **how)

    return rule


def _push_transposed(g, *operands, call, wanted, axis):
    n = len(call.inputs)
    size = axis.size
    values = operands[:n]
    along = operands[n:]
    if any(ad.is_undefined_primal(value) for value in values):
        raise NotImplementedError(TWICE)
    g = [ad.instantiate_zeros(each) for each in g]
    of = Axis(size, axis.of[:n] + (size is not None,) * len(g))
    found = PULL.bind(*values, *g, call=call, wanted=wanted, axis=of)
    sums = [
        x if size is None or own else x.sum(0) for x, own in zip(found, axis.of[n:], strict=True)
    ]
    pairs = zip(sums, along, strict=True)
    return [None] * n + [x if ad.is_undefined_primal(each) else None for x, each in pairs]


APPLY = core.Primitive("fastdyn_apply")


def _product(slopes, row):
    return jnp.einsum("...ij,...j->...i", slopes, row)


def _product_batched(operands, places):
    new = next(x.shape[p] for x, p in zip(operands, places, strict=True) if p is not None)
    fronted = [
        jnp.broadcast_to(x, (new, *x.shape)) if place is None else jnp.moveaxis(x, place, 0)
        for x, place in zip(operands, places, strict=True)
    ]
    return APPLY.bind(*fronted), 0


def _product_transposed(g, slopes, row):
    """An output without a part in the number, g = 0, may be nan, as its slopes."""
    if ad.is_undefined_primal(slopes):
        raise NotImplementedError(TWICE)
    g = ad.instantiate_zeros(g)[..., None]
    return None, jnp.where(g == 0, 0.0, g * slopes).sum(-2)


def _product_jvp(operands, tangents):
    if not isinstance(tangents[0], ad.Zero):
        raise NotImplementedError(TWICE)
    return APPLY.bind(*operands), APPLY.bind(operands[0], ad.instantiate_zeros(tangents[1]))


APPLY.def_impl(_product)
APPLY.def_abstract_eval(
    lambda slopes, row: jax.core.ShapedArray(slopes.shape[:-1], np.dtype(float))
)
mlir.register_lowering(APPLY, mlir.lower_fun(_product, multiple_results=False))
batching.primitive_batchers[APPLY] = _product_batched
ad.primitive_jvps[APPLY] = _product_jvp
ad.primitive_transposes[APPLY] = _product_transposed
ad.primitive_jvps[SLOPES] = _refuse_twice
ad.primitive_jvps[SOLVE] = _solve_jvp
ad.primitive_jvps[PUSH], ad.primitive_jvps[PULL] = _linear_jvp(PUSH), _linear_jvp(PULL)
ad.primitive_transposes[PUSH] = _push_transposed
