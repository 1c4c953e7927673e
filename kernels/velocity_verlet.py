"""VelocityVerlet: the symplectic method of order 2 for q'' = a(t, q), at fixed step.

L. Verlet, "Computer experiments on classical fluids. I", Phys. Rev. 159 (1967), in the velocity
form of W. C. Swope, H. C. Andersen, P. H. Berens and K. R. Wilson, J. Chem. Phys. 76 (1982),
equations (3) to (6): half a kick, a drift, half a kick.
"""

from numba import njit

from . import fixed, start
from .calls import FUSED
from .combine import combine, halves, join, slot
from .dense import cubic
from .method import Method
from .row import Row
from .state import STAGE, K, Y

HALF = Row("1/2")
ONE = Row("1")


@njit(**FUSED)
def step(acceleration, t, y, h, k1, block, form, work):
    """One step; 1 evaluation.  Stages are the derivatives [v, a] at both ends."""
    q, v = halves(y)
    _, a = halves(k1)
    place = slot(form, work, Y)
    q_place, v_place = halves(place)
    end = slot(form, work, K + 1)
    rate_place, a_place = halves(end)
    middle, _ = halves(slot(form, work, STAGE))
    v_middle = combine(middle, v, h, HALF, (a,))
    q_new = combine(q_place, q, h, ONE, (v_middle,))
    a_new = acceleration(t + h, q_new, block, a_place)
    v_new = combine(v_place, v_middle, h, HALF, (a_new,))
    rate = combine(rate_place, v_middle, h, HALF, (a_new,))
    return join(place, q_new, v_new), (k1, join(end, rate, a_new))


VELOCITY_VERLET = Method(
    "VelocityVerlet",
    order=2,
    error_order=0,
    n_stages=1,
    n_rows=2,
    last=1,
    advance=fixed.advance,
    step=step,
    arguments=(1,),
    start=start.second_order,
    n_dense=3,
    enrich=cubic,
    dense_order=2,
    second_order=True,
)
