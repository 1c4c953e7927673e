"""The sweep back over the steps of a solve: ``result.vjp(g)``.

The sweep gives the exact derivative of the discrete solution.  That is not enough: on a stiff
problem the steps of an explicit method may leave the limit of stability where the solution does not
show it, because its fast modes are too small.  The derivatives contain all modes, and grow beyond
all bounds.  So the sweep measures h |J| along the derivatives; beyond the limit of the method, the
problem is solved again with steps within the limit.  The second guard is in `along.py`.
"""

import math

import numpy as np

from fastdyn.kernels.state.record import EVENT, FINISHED
from fastdyn.kernels.stepping.backward import COSINE, LARGEST, RATE
from fastdyn.kernels.stepping.backward_whole import FEW
from fastdyn.problem.sensitivities import START

from .along import KEPT
from .backward import backward_of
from .events import back_over, by_occurrence, checked, counts_of
from .keeping import Keeping
from .legs import legs_of

COPY = (
    "`vjp` lives in this process and is neither pickled nor sent to another one: compute the "
    "derivatives here, or delete the field, `del result['vjp']`."
)
NOT_FINITE = (
    "The derivatives are nan or inf: `fun` has an infinite derivative on the way (a root at 0, a "
    "quotient by 0), an event function touches zero without crossing it, or the derivatives exceed "
    "the largest number."
)
UNSTABLE = (
    "The derivatives grow along modes that the solution does not show: the problem is stiff. "
    "{}: take Rodas5P or Radau, or `sensitivity` with BDF, or shorter steps."
)
UNRESOLVED = "unresolved"  # a key of a Function's notes: each solve is compared with `along`
INSIDE = 0.9  # longest step of a second solve, as a share of the limit of stability
ALWAYS_STABLE = 0.5  # h |J| below which all pairs are stable
STABLE = (0.0, 0.0, 0.0)  # the gauge of a method whose steps are always stable
SMALL = 1e-3  # least size of a component, as a share of the largest, where errors have no tolerance
TRIALS, MOST_TIMES = 4, 20.0  # most solves; most steps of a second solve, over those of the first


class Vjp:
    """The derivatives of a number that depends on the outputs of a solve: ``vjp(g)``.

    The object holds copies of all values from outside; later changes of arguments, arrays and of
    the result change nothing.  Calls in several threads do not disturb each other.

    Parameters
    ----------
    problem : problem.validate.Problem
        Without functions and arguments.
    bound : Bound
        The equations, with copies of their outside values.
    product : compile.derivatives.vjp.Product
    directions : list of problem.sensitivities.Direction
        Without values.
    events : events.OfEvents
    legs : list of legs.Leg
    outputs : list of slice
        The outputs of each leg.
    along : along.Along, optional
        Compares the first gradient.
    """

    def __init__(self, problem, bound, product, directions, events, legs, outputs, along=None):
        self._problem = problem
        self._bound = bound
        self._product = product
        self._directions = directions
        self._events = events
        self._legs = legs
        self._outputs = outputs
        self._along = along
        self._backward = backward_of(problem.method.name, product)

    def __repr__(self):
        names = ", ".join(repr(d.name) for d in self._directions)
        return f"<vjp of {len(self._problem.t_eval)} outputs by {names}>"

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self

    def __reduce__(self):
        raise TypeError(COPY)

    def __call__(self, g=None, t_events=None, y_events=None):
        """The derivatives of a number, from its derivatives by the outputs, and at events.

        Parameters
        ----------
        g : array_like, shape (n, n_points), optional
            The derivatives of the number by the entries of `y`, 0 by default.
        t_events, y_events : list of array_like or None, optional
            Those by the entries of the fields of these names, the times of events and the states at
            these times, before an action: for each event, None or shape (k,) and (k, n).

        Returns
        -------
        dict of str to ndarray or float
            The derivatives by "y0" and by arguments, in their shapes.

        Raises
        ------
        ValueError, TypeError
            For a derivative of another shape, with nan or inf, or not of real numbers; if the
            derivatives are not finite; if an event has no derivative; if the problem is so stiff
            that no steps of the method give them.
        """
        t = self._problem.t_eval
        n = len(self._problem.y0)
        if g is None and (t_events is not None or y_events is not None):
            g = np.zeros((n, len(t)))
        g = checked("g", "y", g, (n, len(t)))
        given = (
            np.ascontiguousarray(g.T),
            by_occurrence(self._events, self._legs, n, t_events, y_events),
        )
        for _ in range(TRIALS):
            legs = self._legs
            found, gauge = self._swept(legs, *given)
            largest = gauge[LARGEST]
            cosine = gauge[COSINE]
            limit = ALWAYS_STABLE if largest < ALWAYS_STABLE else self._backward.stable(cosine)
            if largest > limit:
                self._legs = self._with_steps(INSIDE * limit / gauge[RATE], legs)
            elif not self._is_unresolved(found, given):
                return self._named(found)
        raise ValueError(UNSTABLE.format("Shorter steps did not help"))

    def _is_unresolved(self, found, given):
        """Whether the steps do not resolve the derivatives; other steps are then taken."""
        along = self._along
        self._along = None
        if along is None or not np.isfinite(found).all():
            return False
        by_start = any(d.position == 0 for d in self._directions)
        wanted = slice(0 if by_start else len(self._problem.y0), None)
        found = found[wanted]
        legs = along.legs(self._problem.t_eval, given[0], found)
        if legs is None:
            return False
        off = np.abs(self._swept(legs, *given)[0][wanted] - found).max()
        if off <= KEPT * along.share * np.abs(found).max():
            return False  # the gradient by the other steps is this one: it is exact for the solve
        self._legs = legs
        self._product.bound.function.notes[UNRESOLVED] = True
        return True

    def _named(self, found):
        if not np.isfinite(found).all():
            raise ValueError(NOT_FINITE)
        n = len(self._problem.y0)
        result = {}
        begin = n
        for d in self._directions:
            if d.position == 0:
                result[START] = found[:n].copy()
                continue
            end = begin + d.size
            result[d.name] = found[begin:end].reshape(d.value.shape)[()]
            begin = end
        return result

    def _swept(self, legs, g, at_events):
        """The derivatives by the initial state and by the arguments, and the gauge of a sweep."""
        product = self._product
        lam = np.zeros(len(self._problem.y0))
        memory = self._backward.room(product, self._scale(legs))
        blocks = self._backward.blocks(self._bound, product)
        by_parameters = memory.out[product.n :]
        for leg, own in zip(reversed(legs), reversed(self._outputs), strict=True):
            lam = self._over_end(leg, lam, at_events, by_parameters)
            t, seeds = self._seeds(leg, own, g, lam, at_events, by_parameters)
            if len(leg.steps.t):
                lam = self._backward.over(leg, t, seeds, blocks, memory)
            else:
                lam = seeds.sum(axis=0)
        return np.concatenate([lam, by_parameters]), getattr(memory, "gauge", STABLE)

    def _scale(self, legs):
        """The sizes of errors of the components."""
        p = self._problem
        several = [leg.states[:: 1 + len(leg.states) // FEW] for leg in legs]
        sizes = np.abs(np.concatenate(several)).max(axis=0)
        if p.method.error_order:
            scale = p.atol + p.rtol * sizes
            return np.where(np.isfinite(scale), scale, 0.0)  # discrete states have no errors
        if p.method.backward == "kicks":
            return np.full(len(sizes), 1.0)
        halves = sizes.reshape(1 + p.method.second_order, -1)
        return (halves + SMALL * halves.max(axis=1, keepdims=True)).ravel()

    def _over_end(self, leg, lam, at_events, out):
        """The derivatives by the state before the end of a leg, from those behind it."""
        for each in reversed(leg.ends):
            if each.acted:
                lam, found = back_over(self._events.acting[each.place], each, lam)
                out += found
            lam = lam + self._of_occurrence(each, at_events, out)
        return lam

    def _of_occurrence(self, occurrence, at_events, out):
        """The derivatives by the state at the time of an occurrence, held fixed."""
        by_state, by_time = at_events.get(occurrence[:2], (None, 0.0))
        if by_state is None:
            return 0.0
        passive = self._events.passive[occurrence.place]
        if passive is None:
            return by_state
        found, by_parameters = back_over(passive, occurrence, by_state, by_time)
        out += by_parameters
        return found

    def _seeds(self, leg, own, g, lam, at_events, out):
        """The times and derivatives of what depends on the states of a leg, in order of time."""
        t = self._problem.t_eval[own]
        rows = g[own]
        more = [(each.t, self._of_occurrence(each, at_events, out)) for each in leg.seen
                if each[:2] in at_events]  # fmt: skip
        if leg.ends:
            more.append((leg.ends[0].t, lam))
        if not more:
            return t, rows
        sign = 1.0 if self._problem.tf >= self._problem.t0 else -1.0
        t = np.concatenate([t, [time for time, _ in more]])
        order = np.argsort(sign * t, kind="stable")
        return t[order], np.vstack([rows, *[each for _, each in more]])[order]

    def _with_steps(self, h_max, legs):
        """The legs of the problem solved again with steps of at most `h_max`."""
        p = self._problem
        events = self._events
        n_steps = sum([len(leg.t) - 1 for leg in legs])
        if abs(p.tf - p.t0) / h_max > MOST_TIMES * n_steps:
            raise ValueError(UNSTABLE.format(f"Stable steps are {h_max:.1e}, too many"))
        shorter = {"h_max": min(h_max, p.h_max)}
        if not p.method.error_order:
            shorter = {"h": p.h / math.ceil(p.h / h_max)}
        run = solved_again(p._replace(**shorter), self._bound, events.others)
        if run is None:
            raise ValueError(UNSTABLE.format("A solve with shorter steps failed"))
        found = legs_of(run)
        places = len(events.order)
        if len(found) != len(legs) or counts_of(found, places) != counts_of(legs, places):
            raise ValueError(UNSTABLE.format("With stable steps, other events occur"))
        return found


def solved_again(problem, bound, others):
    """A Keeping run that has solved a problem by these Bounds; None if it failed."""
    p = problem._replace(t_eval=np.array([problem.tf]), dense_output=False)
    run = Keeping(p, bound, list(others))
    return run if run.again() in (FINISHED, EVENT) else None
