"""RK23: the Bogacki-Shampine pair of order 3(2), first same as last, cubic Hermite dense output.

P. Bogacki and L. F. Shampine, "A 3(2) pair of Runge-Kutta formulas", Appl. Math. Lett. 2 (1989),
equation (5).
"""

from .explicit import pair
from .tableau import Row, Table, tableau

STAGES = tableau("1/2: 1/2; 3/4: 0 3/4")
B = Row("2/9 1/3 4/9")
EMBEDDED = Row("7/24 1/4 1/3 1/8")
TABLE = Table(STAGES, B, (EMBEDDED - B,))
RK23 = pair("RK23", TABLE, order=3, error_order=2, dense_order=3)
