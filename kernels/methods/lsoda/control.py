"""The next step of LSODA: size, order, and family of formulas, Adams' or BDF.

K. Radhakrishnan and A. C. Hindmarsh, NASA RP-1327 (1993), section 2.7: orders and sizes.
L. Petzold, "Automatic selection of methods for solving stiff and nonstiff systems", SIAM J. Sci.
Stat. Comput. 4 (1983): steps that stability allows, and the change of the family.
"""

from ...jit.options import INLINED, INTERNAL, njit
from .corrector import EPS
from .past import CHANGE, FOUND, KEPT, Z, norm
from .table import ADAMS, BDF, CONSTANT, CORRECTION, HIGHER, LOWER, ORDERS, STABLE

LEAST = 1e-6  # the least value of h L in a bound of stability
LONGER = 1.1  # the smallest factor by which a step is made longer
AGAIN = 3  # steps to wait if the size does not change
FIRST_GROWTH, GROWTH, SHRUNK_GROWTH = 1e4, 10.0, 2.0  # as in ODEPACK
BETTER, WAIT = 5.0, 20  # ratio of BDF's step to Adams' for a change; steps between two changes


@njit(**INTERNAL)
def growth(error, order, bias):
    """The factor for the step size, from the error of a step by a formula of this order."""
    return 1.0 / (bias * error ** (1.0 / (order + 1)) + bias * 1e-6)


@njit(**INLINED)
def highest(s, family):
    """The highest order of a family, at most that of the table."""
    return s.highest_adams if family == ADAMS else s.highest_bdf


@njit(**INTERNAL)
def load_formula(s):
    """Take the first coefficient of the formula of the present family and order."""
    l0 = CORRECTION[s.stiff, s.order, 0]
    s.drift *= l0 / s.l0
    s.l0 = l0


@njit(**INTERNAL)
def change_step(s, factor):
    """Change the step size by a factor, within its limits; return the factor taken."""
    factor = min(factor, s.growth)
    factor /= max(1.0, s.h / s.h_max * factor)
    if s.stiff == 0:
        s.limited = 0
        bound = max(s.h * s.lipschitz, LEAST)
        if factor * bound * 1.00001 >= STABLE[s.order]:
            factor = STABLE[s.order] / bound
            s.limited = 1
    s.h *= factor
    s.drift *= factor
    s.wait = s.order + 1
    return factor


@njit(**INTERNAL)
def next_order(s, work, error, n_failed):
    """Choose the order of the next step; return the factor for its size, or 0 for no change.

    `n_failed` counts the failures of the step.  The order rises only after an accepted step.
    """
    order = s.order
    family = s.stiff
    same = growth(error, order, 1.2)
    lower = 0.0
    higher = 0.0
    bound = 0.0
    if n_failed == 0 and order < highest(s, family):
        for i in range(work.shape[1]):
            work[FOUND, i] = work[CHANGE, i] - work[KEPT, i]
        higher = growth(norm(work, FOUND) / HIGHER[family, order], order + 1, 1.4)
    if order > 1:
        lower = growth(norm(work, Z + order) / LOWER[family, order], order - 1, 1.3)
    if family == ADAMS:
        bound = max(s.h * s.lipschitz, LEAST)
        if order < highest(s, ADAMS):
            higher = min(higher, STABLE[order + 1] / bound)
        same = min(same, STABLE[order] / bound)
        if order > 1:
            lower = min(lower, STABLE[order - 1] / bound)
        s.lipschitz_now = 0.0
    chosen = order
    factor = same
    if same >= higher:
        if same < lower:
            chosen = order - 1
            factor = lower
    elif higher > lower:
        if higher < LONGER:
            return 0.0
        _append_term(s, work)
        chosen = order + 1
        factor = higher
    else:
        chosen = order - 1
        factor = lower
    if chosen < order and n_failed > 0:
        factor = min(factor, 1.0)
    limited = family == ADAMS and factor * bound * 1.00001 >= STABLE[chosen]
    if chosen <= order and not limited and n_failed == 0 and factor < LONGER:
        return 0.0
    if chosen <= order and n_failed >= 2:
        factor = min(factor, 0.2)
    if chosen != order:
        s.order = chosen
        load_formula(s)
    return factor


@njit(**INTERNAL)
def _append_term(s, work):
    """Append a term to the Nordsieck array, for a higher order."""
    share = CORRECTION[s.stiff, s.order, s.order] / (s.order + 1)
    for i in range(work.shape[1]):
        work[Z + s.order + 1, i] = share * work[CHANGE, i]


@njit(**INTERNAL)
def next_family(s, work, error, predicted):
    """Change the family if the other family takes longer steps.

    Returns the factor for the step size; 0 without a change.  `predicted` is the norm of the
    predicted state: the error must exceed the rounding error of this state.  The order is at most
    the highest of the other family.
    """
    family = 1 - s.stiff
    order = min(s.order, highest(s, family))
    if order == 0:  # the user wants the present family alone
        return 0.0
    of_order = s, work, error, order
    factor = _to_bdf(*of_order, predicted) if s.stiff == 0 else _to_adams(*of_order, predicted)
    if factor > 0.0:
        s.stiff = family
        s.order = order
        s.wait_family = WAIT
        s.lipschitz = 0.0
    return factor


@njit(**INTERNAL)
def _other_error(s, work, error, order, family):
    """The error of a step of another family, of the present order or of a lower order."""
    if order < s.order:
        return norm(work, Z + order + 1) / LOWER[family, order + 1]
    return error * (CONSTANT[family, order] / CONSTANT[1 - family, order])


@njit(**INTERNAL)
def _stable_growth(s, factor, order, constant):
    """The factor for the step size of Adams' formula, from the bound on the step times L."""
    bound = constant * s.h
    if bound * factor > 1e-5:
        return min(factor, STABLE[order] / bound)
    return factor


@njit(**INTERNAL)
def _to_bdf(s, work, error, order, predicted):
    if s.order > ORDERS[BDF]:
        return 0.0
    if not (error > 100.0 * predicted * EPS and s.lipschitz_now != 0.0):
        return 2.0 if s.limited == 1 else 0.0
    ours = _stable_growth(s, growth(error, s.order, 1.2), s.order, s.lipschitz)
    factor = growth(_other_error(s, work, error, order, BDF), order, 1.2)
    return factor if factor >= BETTER * ours else 0.0


@njit(**INTERNAL)
def _to_adams(s, work, error, order, predicted):
    theirs = _other_error(s, work, error, order, ADAMS)
    factor = _stable_growth(s, growth(theirs, order, 1.2), order, s.jacobian_norm)
    if factor < growth(error, s.order, 1.2):
        return 0.0
    share = max(0.001, factor) ** (1.0 / (order + 1))
    return factor if share * theirs > 1000.0 * EPS * predicted else 0.0
