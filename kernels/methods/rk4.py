"""RK4: the classical Runge-Kutta method of order 4 at fixed step, cubic Hermite dense output.

W. Kutta, "Beitrag zur naeherungsweisen Integration totaler Differentialgleichungen",
Z. Math. Phys. 46 (1901).  The derivative at the end of a step is kept: it is the first stage of
the next one and the end slope of the interpolant.
"""

from ..jit_options import FUSED, njit
from ..output.dense_output import cubic
from ..state.elementwise import combine, slot
from ..state.record import STAGE, K, Y
from ..stepping import first_step, fixed
from .method import Method
from .tableau import Row

C = Row("0 1/2 1/2 1")
c = C.floats
A2 = Row("1/2")
A3 = Row("0 1/2")
A4 = Row("0 0 1")
B = Row("1/6 1/3 1/3 1/6")
TABLEAU = {"c": C, "a": (Row(), A2, A3, A4), "b": B}


@njit(**FUSED)
def step(rhs, t, y, h, k1, low, block, form, work):
    """One step; 4 evaluations."""
    u = slot(form, work, STAGE)
    k2 = rhs(t + c[1] * h, combine(u, y, h, A2, (k1,)), block, slot(form, work, K + 1))
    k3 = rhs(t + c[2] * h, combine(u, y, h, A3, (k1, k2)), block, slot(form, work, K + 2))
    k4 = rhs(t + c[3] * h, combine(u, y, h, A4, (k1, k2, k3)), block, slot(form, work, K + 3))
    y_new = combine(slot(form, work, Y), y, h, B, (k1, k2, k3, k4))
    k5 = rhs(t + h, y_new, block, slot(form, work, K + 4))
    return y_new, (k1, k2, k3, k4, k5)


RK4 = Method(
    "RK4",
    order=4,
    error_order=0,
    n_stages=4,
    n_rows=5,
    last=4,
    advance=fixed.advance,
    step=step,
    arguments=(4, 4),
    start=first_step.plain,
    n_dense=3,
    enrich=cubic,
    dense_order=3,
    tableau=TABLEAU,
)
