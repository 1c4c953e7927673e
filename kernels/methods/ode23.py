"""ode23: the pair of RK23 under MATLAB's control of the step; see `step_size.matlab`.

The counts of steps agree with the counts that MathWorks publishes.  The counts do not depend on the
least factor of a first rejection, 0.5 here.
"""

from . import rk23
from .ode45 import as_in_matlab

ODE23 = as_in_matlab("ode23", rk23.RK23, rk23.TABLE, 0.5)
