"""The loop over paths of stochastic equations: with functions inside, or by their addresses.

Needs no Numba before a kernel is compiled.
"""

import functools

from fastdyn import code_store
from fastdyn.compile.sentences import Uncompilable

from .in_lanes import linked, texts_of

SYMBOL = "fastdyn_function"
SLOPE = f"{SYMBOL}_slope"
MADE_IN = "kernels.noise.around", "specialise.noise", "specialise.signatures.noise"


def in_lanes(plan, forms, width):
    """The code of the loop of a Plan on vectors.

    `forms` are the `VectorForm` of the drift, of the columns of the diffusion and of the events,
    whose parameters follow each other in the block.
    """
    if any(form.raises for form in forms):
        raise Uncompilable("a function can raise an exception, which vectors do not notice")
    symbols = [f"{SYMBOL}{i}" for i in range(len(forms))]
    texts, begins = texts_of(symbols, forms)
    slope = None
    if plan.method.derivative:
        found, text = forms[1].jacobian(False)
        texts[SLOPE] = functools.partial(text, skip=begins[1])
        slope = found.size, *(list(map(int, each)) for each in (found.rows, found.columns))
    shapes = [form.n_results for form in forms]

    def build():
        from .dispatchers import around_paths
        from .vector_rhs import named, number

        functions = [number(named(*each)) for each in zip(symbols, shapes, strict=True)]
        derivative = None
        if slope is not None:
            derivative = number(named(SLOPE, slope[0])), *slope[1:]
        return around_paths("in_lanes", plan, functions, derivative, width)

    key = f"noise {plan} {width} {[form.key for form in forms]}"
    place = f"noise waits {plan} {width} {shapes} {slope}"
    return linked(key, place, texts, build, *MADE_IN)


def by_address(plan):
    """The code of the loop of a Plan for functions that the block names, one path at a time."""

    def build():
        from .dispatchers import around_paths

        return around_paths("by_address", plan)

    made_by = code_store.KERNELS.around(*MADE_IN)
    return code_store.compiled(f"noise by address {plan}", build, made_by)
