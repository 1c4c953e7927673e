"""Time transformation: constant steps in another time, which are short where the motion is fast."""

import types
from collections.abc import Callable
from typing import Any

from fastdyn.kernels.calls.time_scaling import scaled


def time_transformed(fun: Callable[..., Any], density: Callable[..., Any]) -> Callable[..., Any]:
    """
    Transform the time of a motion that is alternately fast and slow, for constant steps.

    With dt = density(t, y) ds, a constant step ds is a step of density times ds in t.  On an
    eccentric orbit with ``density = r`` (K. F. Sundman, Acta Math. 36 (1912)), the steps are spread
    evenly over the ellipse.  A symmetric method (Gauss4, Gauss8, Gauss16) keeps the energy of a
    reversible motion without drift, with and without the transformation.

    Parameters
    ----------
    fun : function
        ``fun(t, y, *args)``.
    density : function
        ``density(t, y, *args)``, positive; large where steps may be long.

    Returns
    -------
    function
        ``fun(s, w, *args)`` for the longer state w = [y, t].  The initial state is ``[*y0, t0]``;
        the last component of the solution is the time.

    Raises
    ------
    TypeError
        If `fun` or `density` is not a plain Python function.
    """
    if not isinstance(fun, types.FunctionType) or not isinstance(density, types.FunctionType):
        raise TypeError("`fun` and `density` must be plain Python functions.")

    def by_another_clock(s, w, *args):
        y = w[:-1]
        t = w[-1]
        return scaled(fun(t, y, *args), density(t, y, *args))

    return by_another_clock
