"""RK4: the classical Runge-Kutta method of order 4 at fixed step, cubic Hermite dense output.

W. Kutta, "Beitrag zur naeherungsweisen Integration totaler Differentialgleichungen",
Z. Math. Phys. 46 (1901).  The derivative at the end of a step is the first stage of the next step
and the end slope of the interpolant.
"""

from .explicit import single
from .tableau import Row, Table, tableau

TABLE = Table(tableau("1/2: 1/2; 1/2: 0 1/2; 1: 0 0 1"), Row("1/6 1/3 1/3 1/6"))
RK4 = single("RK4", TABLE, order=4, dense_order=3)
