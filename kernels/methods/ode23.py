"""ode23: the pair of RK23 under MATLAB's control of the step; see `step_size.matlab`.

The counts that MathWorks publishes come out; they do not depend on the share that a first
rejection leaves, 0.5 here.
"""

from . import rk23
from .ode45 import as_in_matlab

ODE23 = as_in_matlab("ode23", rk23.RK23, rk23.TABLE, 0.5)
