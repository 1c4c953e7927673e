"""RK23: the Bogacki-Shampine pair of order 3(2), first same as last, cubic Hermite dense output.

P. Bogacki and L. F. Shampine, "A 3(2) pair of Runge-Kutta formulas", Appl. Math. Lett. 2 (1989),
equation (5).
"""

from ..jit_options import FUSED, njit
from ..output.dense_output import cubic
from ..state.elementwise import combine, slot, weigh
from ..state.record import STAGE, K, Y
from ..stepping import adaptive, first_step
from ..stepping.step_size import SCIPY, rms
from .method import Method
from .tableau import Row

C = Row("0 1/2 3/4 1")
c = C.floats
A2 = Row("1/2")
A3 = Row("0 3/4")
B = Row("2/9 1/3 4/9")
E = Row("5/72 -1/12 -1/9 1/8")
TABLEAU = {"c": C, "a": (Row(), A2, A3, B), "b": B, "e": (E,)}


@njit(**FUSED)
def step(rhs, t, y, h, k1, block, form, work, rtol, atol):
    """One step tried; 3 evaluations."""
    u = slot(form, work, STAGE)
    k2 = rhs(t + c[1] * h, combine(u, y, h, A2, (k1,)), block, slot(form, work, K + 1))
    k3 = rhs(t + c[2] * h, combine(u, y, h, A3, (k1, k2)), block, slot(form, work, K + 2))
    y_new = combine(slot(form, work, Y), y, h, B, (k1, k2, k3))
    k4 = rhs(t + h, y_new, block, slot(form, work, K + 3))
    k = (k1, k2, k3, k4)
    return y_new, k, rms(weigh(u, h, E, k), y, y_new, rtol, atol)


RK23 = Method(
    "RK23",
    order=3,
    error_order=2,
    n_stages=3,
    n_rows=4,
    last=3,
    advance=adaptive.advance,
    step=step,
    arguments=(SCIPY, -1 / 3, 3),
    start=first_step.hairer,
    n_dense=3,
    enrich=cubic,
    dense_order=3,
    tableau=TABLEAU,
)
