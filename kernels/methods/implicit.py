"""The common fields of methods whose steps solve equations."""

from functools import partial

from ..state.record import K
from ..stepping import first_step
from ..stepping.implicit import begins_in_step, kernel
from .complex_states import implicit_of_pairs
from .method import method, with_complex_states


def implicit(
    name, step, slope, begin=begins_in_step, *, dense_order, start=first_step.implicit,
    on_pairs=False, **more,
):  # fmt: skip
    """A Method of adaptive step on rows.

    Parameters
    ----------
    name : str
    step : function
        ``step(rhs, state, work, block, h_min)``; see `stepping/implicit.py`.
    slope : int
        The row of the derivative at the end of a step.
    begin : function, optional
        ``begin(rhs, state, work, block)``; see `stepping/implicit.py`.
    start : function, optional
    dense_order : int
        Order and rows of the interpolant.
    on_pairs : bool
        True if the steps also take complex states, as pairs of real numbers.
    **more
        Other fields; see `method`.
    """
    found = method(
        name,
        n_stages=0,
        fsal_stage=slope - K,
        kernel=partial(kernel, begin, step),
        start=start,
        n_dense=dense_order,
        dense_order=dense_order,
        **more,
    )
    return with_complex_states(found, found.kernel, implicit_of_pairs) if on_pairs else found
