"""RK45: the Dormand-Prince pair of order 5(4), first same as last, with dense output of order 4.

Coefficients: J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae",
J. Comput. Appl. Math. 6 (1980), table 2.  Dense output: L. F. Shampine, "Some practical
Runge-Kutta formulas", Math. Comp. 46 (1986), written as the cubic Hermite polynomial plus
x^2 (1 - x)^2 h D.k, after Hairer, Norsett and Wanner, "Solving Ordinary Differential
Equations I", section II.6.
"""

from .explicit import pair
from .tableau import Row, Table, tableau

STAGES = tableau(
    """
    1/5: 1/5;
    3/10: 3/40 9/40;
    4/5: 44/45 -56/15 32/9;
    8/9: 19372/6561 -25360/2187 64448/6561 -212/729;
    1: 9017/3168 -355/33 46732/5247 49/176 -5103/18656
    """
)
B = Row("35/384 0 500/1113 125/192 -2187/6784 11/84")
E = Row("-71/57600 0 71/16695 -71/1920 17253/339200 -22/525 1/40")
D = Row(
    "-12715105075/11282082432 0 87487479700/32700410799 -10690763975/1880347072 "
    "701980252875/199316789632 -1453857185/822651844 69997945/29380423"
)
TABLE = Table(STAGES, B, (E,), (D,))
RK45 = pair("RK45", TABLE, order=5, error_order=4, dense_order=4)
