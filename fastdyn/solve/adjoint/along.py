"""The second guard of `vjp`: one solve with the derivative along a direction in its error control.

The steps of a solve resolve the solution.  They do not resolve a fast oscillation that is smaller
than the tolerance, nor the derivatives by what moves it, though the sweep is exact and stable.  So
some solves are made again together with the derivative s = S v along one direction v, whose errors
the steps then control, too, and g . s is compared with the gradient times v.  Where they differ,
these steps take the place of the others.
"""

import numpy as np

from fastdyn.compile.derivatives.vjp import bind_direction
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.state.record import FINISHED
from fastdyn.problem.events import without_functions
from fastdyn.problem.sensitivities import Tolerances

from .keeping import Keeping
from .legs import legs_of

MOST = 1000  # components and parameters, for which the longer equations compile in a second
# A gradient by the steps of a solve is off by 0.1 to 10 times the error of the solution, by more at
# kinks.  The share MORE times the root of the tolerance, at most APART, is above that: of eight
# problems by five methods at 1e-3, 1e-6 and 1e-8, a satellite at 1e-3 was solved again, by three.
# A gradient is left where the other steps give one that is off by less than KEPT shares: that of an
# epidemic with a kink, at 1e-8, by 1.9; those of hidden oscillations, at 1e-6, by 14 and more.
MORE = 10.0
APART = 0.1
KEPT = 3.0
# The direction of a number p is a p + b ELSE, with random a and b from LEAST to 1, of either sign:
# of the size of p, not 0 where p is, and not one number for equal ones.
ELSE = 0.5 * (5.0**0.5 - 1.0)
LEAST = 0.5


class Along:
    """A solve that can be made again, in any thread, with the derivative along a direction.

    Parameters
    ----------
    problem : problem.validate.Problem
    directions : list of problem.sensitivities.Direction

    Raises
    ------
    Uncompilable
        If the longer equations are not compiled.
    """

    def __init__(self, problem, directions):
        p = problem
        n = len(problem.y0)
        values = np.concatenate([d.value.ravel() for d in directions if d.position] or [[]])
        rng = np.random.default_rng(0)
        shape = 2, n + len(values)
        turns = rng.uniform(LEAST, 1.0, shape) * rng.choice((-1.0, 1.0), shape)
        turns[1] *= ELSE
        v = turns[0] * np.concatenate([p.y0, values]) + turns[1]
        by_start = any(d.position == 0 for d in directions)
        self._v = v if by_start else v[n:]
        positions = tuple([d.position for d in directions if d.position])
        near = Near(p.t0, p.tf, p.y0)
        of_values = np.ascontiguousarray(turns[:, n:])
        self._bound = bind_direction(p.fun, p.args, near, positions, of_values, p.mode)
        tolerances = Tolerances(p, 1)
        rtol = float(np.max(p.rtol))
        self.share = min(APART, MORE * rtol**0.5 or APART)
        self._problem = without_functions(p)._replace(
            y0=np.concatenate([p.y0, v[:n] if by_start else np.zeros(n)]),
            rtol=tolerances.rtol, atol=tolerances.atol(np.ones(1)),
        )  # fmt: skip

    def legs(self, t_eval, g, gradient):
        """The legs with the steps of the longer solve; None where the gradient agrees with it.

        `g`, of shape (n_points, n), are the derivatives by the outputs at `t_eval`; `gradient` has
        those by y0, if it is a direction, and by the parameters.
        """
        run = Keeping(self._problem._replace(t_eval=t_eval), self._bound, [])
        if run.again() != FINISHED:
            return None
        n = g.shape[1]
        terms = gradient * self._v
        other = (g * run.output.points()[1][:, n:]).ravel()
        size = np.abs(terms).sum() + self.share * np.abs(other).sum()
        if not np.abs(terms.sum() - other.sum()) > self.share * size:
            return None
        return [leg._replace(states=leg.states[:, :n].copy()) for leg in legs_of(run)]


def along_of(problem, directions):
    """The Along of a problem; None where there is none."""
    p = problem
    size = len(p.y0) + sum([d.size for d in directions])
    if not p.method.error_order or p.events or p.schedules or size > MOST:
        return None
    if not np.isfinite(np.sum(p.atol)):  # discrete states
        return None
    try:
        return Along(p, directions)
    except Uncompilable:
        return None
