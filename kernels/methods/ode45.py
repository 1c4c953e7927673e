"""ode45: the pair of RK45 under MATLAB's control of the step; see `step_size.matlab`."""

from ..stepping import first_step
from ..stepping.step_size import MATLABS, matlab
from . import rk45
from .explicit import pair


def as_in_matlab(name, scipys, table, least):
    """A pair under MATLAB's control of the step; for `least` see `step_size.matlab`."""
    given = scipys.facts
    return pair(
        name, table, order=given.order, error_order=given.error_order,
        dense_order=given.dense_order, dense_rows=scipys.dense_rows, norm=MATLABS,
        control=matlab(least), start=first_step.matlab, h_max_share=0.1,
    )  # fmt: skip


ODE45 = as_in_matlab("ode45", rk45.RK45, rk45.TABLE, 0.1)
