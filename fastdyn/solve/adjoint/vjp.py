"""The sweep back over the steps of a solve: ``result.vjp(g)``.

The sweep gives the exact derivative of the discrete solution.  That is not enough: on a stiff
problem the steps of an explicit method may leave the limit of stability where the solution does not
show it, because its fast modes are too small.  The derivatives contain all modes, and grow beyond
all bounds.  So the sweep measures h |J| along the derivatives; beyond the limit of the method, the
problem is solved again with steps within the limit.
"""

import numpy as np

from fastdyn.code_store import Call
from fastdyn.kernels.methods.adjoint import Memory, Seeds, stable_size, table_of
from fastdyn.kernels.state.record import FINISHED
from fastdyn.kernels.stepping.backward import COSINE, LAM, LARGEST, RATE, SCALE
from fastdyn.problem.sensitivities import START
from fastdyn.specialise.scalar import replay_kernel, sweep_kernel

from .keeping import Keeping, kept_of

COPY = (
    "`vjp` lives in this process and is neither pickled nor sent to another one: compute the "
    "derivatives here, or delete the field, `del result['vjp']`."
)
NOT_FINITE = (
    "The derivatives are nan or inf: `fun` has an infinite derivative on the way (a root at 0, a "
    "quotient by 0), or they exceed the largest number."
)
UNSTABLE = (
    "The derivatives grow along modes that the solution does not show: the problem is stiff. "
    "{}: take `sensitivity` with Radau, BDF or Rodas5P, or a smaller `max_step`."
)
INSIDE = 0.9  # longest step of a second solve, as a share of the limit of stability
GROWING = 0.2  # cosine above which the motion itself grows, so that no limit holds
ALWAYS_STABLE = 0.5  # h |J| below which all pairs are stable
FEW = 8  # states that tell the sizes of components
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
    kept : keeping.Kept
    """

    def __init__(self, problem, bound, product, directions, kept):
        self._problem, self._bound, self._product = problem, bound, product
        self._directions, self._kept = directions, kept
        self._table = table_of(problem.method.name)

    def __repr__(self):
        names = ", ".join(repr(d.name) for d in self._directions)
        return f"<vjp of {len(self._problem.t_eval)} outputs by {names}>"

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self

    def __reduce__(self):
        raise TypeError(COPY)

    def __call__(self, g):
        """The derivatives of a number, from its derivatives by the outputs.

        Parameters
        ----------
        g : array_like, shape (n, n_points)
            The derivatives of the number by the entries of `y`.

        Returns
        -------
        dict of str to ndarray or float
            The derivatives by "y0" and by arguments, in their shapes.

        Raises
        ------
        ValueError, TypeError
            For a `g` of another shape, with nan or inf, or not of real numbers; if the derivatives
            are not finite; if the problem is so stiff that no steps of the method give them.
        """
        g = self._checked(g)
        for _ in range(TRIALS):
            kept = self._kept
            found, gauge = self._swept(kept, g)
            largest, cosine = gauge[LARGEST], gauge[COSINE]
            if largest < ALWAYS_STABLE or cosine > GROWING:
                return self._named(found)
            limit = stable_size(self._problem.method.name, cosine)
            if largest <= limit:
                return self._named(found)
            self._kept = self._with_steps(INSIDE * limit / gauge[RATE], kept)
        raise ValueError(UNSTABLE.format("Shorter steps did not help"))

    def _checked(self, g):
        found, shape = np.asarray(g), (len(self._problem.y0), len(self._problem.t_eval))
        if found.dtype.kind not in "fiub":
            raise TypeError(f"`g` must be real numbers; got an array of {found.dtype}.")
        if found.shape != shape:
            raise ValueError(
                f"`g` has the derivatives by `y` and so its shape, {shape}; got {found.shape}."
            )
        if not np.isfinite(found).all():
            raise ValueError("`g` contains nan or inf.")
        return np.ascontiguousarray(found.T, dtype=float)

    def _named(self, found):
        if not np.isfinite(found).all():
            raise ValueError(NOT_FINITE)
        result, begin = {}, self._product.n
        for d in self._directions:
            if d.position == 0:
                result[START] = found[: self._product.n].copy()
                continue
            end = begin + d.size
            result[d.name] = found[begin:end].reshape(d.value.shape)[()]
            begin = end
        return result

    def _swept(self, kept, g):
        """The derivatives by the initial state and by the arguments, and the gauge of a sweep."""
        n, table = self._product.n, self._table
        work, out, gauge = np.zeros((table.n_rows, n)), np.zeros(n + self._product.m), np.zeros(3)
        single = 4 * len(table.c)
        sizes = np.abs(kept.states[:: 1 + len(kept.states) // FEW]).max(axis=0)
        work[single + SCALE] = self._problem.atol + self._problem.rtol * sizes
        memory = Memory(work, work[: 2 * len(table.c)].reshape(-1, 2 * n), out, gauge)
        seeds = Seeds(self._problem.t_eval, kept.t, g, np.zeros(len(table.c)), np.array([len(g)]))
        blocks = self._bound.block.copy(), self._product.bound.block.copy()
        for first, states in self._segments(kept, work, blocks[0]):
            Call(
                sweep_kernel(), *_flat(table), *kept.steps, first, states, *seeds, *blocks, *memory
            )()
        out[:n] = work[single + LAM]
        return out, gauge

    def _segments(self, kept, work, block):
        """Yield the number of the first step, and the states, of each segment from the last on."""
        n_steps = len(kept.t) - 1
        if kept.apart == 1:
            yield 0, kept.states
            return
        room = np.empty((kept.apart + 1, self._product.n))
        for i in range(len(kept.states) - 1, -1, -1):
            first = i * kept.apart
            states = room[: min(kept.apart, n_steps - first) + 1]
            if len(states) < 2:
                continue
            states[0] = kept.states[i]
            Call(
                replay_kernel(), *_flat(self._table), *kept.steps, first, states, block,
                np.zeros_like(work),
            )()  # fmt: skip
            yield first, states

    def _with_steps(self, h_max, kept):
        """The Kept of the problem solved again with steps of at most `h_max`."""
        p = self._problem
        n_steps = len(kept.t) - 1
        if abs(p.tf - p.t0) / h_max > MOST_TIMES * n_steps:
            raise ValueError(UNSTABLE.format(f"Stable steps are {h_max:.1e}, too many"))
        run = Keeping(p._replace(h_max=min(h_max, p.h_max)), self._bound, [])
        if run.again() != FINISHED:
            raise ValueError(UNSTABLE.format("A solve with shorter steps failed"))
        return kept_of(run)


def _flat(table):
    """The fields of a Table one by one."""
    return (table.n_stages, table.c, *table.rows, *table.columns, *table.seeded, *table[-2:])
