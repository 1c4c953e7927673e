"""Compiled kernels.  METHODS has one entry a method; a new method is a file and a line here."""

from .dop853 import DOP853
from .gauss import ENERGY_CONSERVING, GAUSS, NYSTROM
from .rk4 import RK4
from .rk23 import RK23
from .rk45 import ODE45, RK45
from .symplectic import SYMPLECTIC

RUNGE_KUTTA = (RK23, RK45, DOP853, ODE45, RK4)
METHODS = {m.name: m for m in (*RUNGE_KUTTA, *SYMPLECTIC, *GAUSS, *NYSTROM, *ENERGY_CONSERVING)}
