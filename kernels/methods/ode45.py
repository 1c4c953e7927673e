"""ode45: the pair of RK45 under MATLAB's control of the step; see `step_size.matlab`."""

from ..stepping import first_step
from ..stepping.step_size import largest, matlab
from . import rk45
from .explicit import make_estimate, make_step, pair


def as_in_matlab(name, table, least, **more):
    """A pair under MATLAB's control; `least` is that of `step_size.matlab`."""
    (error,) = table.errors
    return pair(
        name,
        table,
        make_step(table, make_estimate(error, largest)),
        control=matlab(least),
        start=first_step.matlab,
        h_max_share=0.1,
        **more,
    )


ODE45 = as_in_matlab(
    "ode45",
    rk45.TABLE,
    0.1,
    order=5,
    error_order=4,
    dense_order=4,
    dense_rows=rk45.dense_rows,
)
