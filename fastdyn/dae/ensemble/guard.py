"""A guard against singularities that a step passes: the equations are singular between its ends.

An ensemble keeps no steps, whose ends `reduced/history.py` could compare later.  So the state of a
trajectory is followed by the elements of the matrix at the end of the step before, and by a mark,
which the projection renews after each step: 1 if det(A B') <= 0 for the matrices A, B of both ends.
By the formula of Cauchy and Binet that is so if all minors of full rank change their signs.  A mark
is a suspicion: a solve of the trajectory alone, which looks into the step, decides.
"""

import numpy as np

from fastdyn.problem.options.tolerances import longer_tolerances

from ..structure.eliminate import is_fixed

LARGEST = 6  # rows of a determinant on symbols; above, a bound of norms takes its place


class Guard:
    """The guard of the equations of a Reduction.

    Attributes
    ----------
    size : int
        The number of components behind a state, 0 if no singularity can be passed.
    """

    def __init__(self, reduction):
        system = reduction.system
        self._places = {place: k for k, place in enumerate(system.matrix)}
        nodes = list(system.matrix.values())
        self.size = 0
        self._moving = [k for k, node in enumerate(nodes) if not is_fixed(node)]
        self._n = len(system.states)
        self._elements = reduction.elements()
        self._projection = reduction.projection
        if not self._moving:
            return
        self.size = len(self._moving) + 1
        c, d = system.offsets
        moving = np.array(list(self._places))[self._moving]
        self._parts: list = []
        for m in range(int(c.max(initial=0)) + 1):
            rows, columns = (np.flatnonzero(each >= m).tolist() for each in (c, d))
            moves = np.isin(moving[:, 0], rows) & np.isin(moving[:, 1], columns)
            if moves.any() and (rows, columns) not in self._parts:
                self._parts.append((rows, columns))

    def memory(self, system, t, z):
        """The components behind states at their starts, (k, size); z as of `system.numbers`."""
        nodes = list(system.matrix.values())
        numbers = system.numbers([nodes[k] for k in self._moving], t, z)
        return np.column_stack([numbers.T, np.zeros(len(t))])

    def tolerances(self, options, method):
        """The options for the longer state; the components behind count in no error."""
        given = options["rtol"], options["atol"]
        rtol, atol = longer_tolerances(method, *given, self._n, self.size)
        return {**options, "rtol": rtol, "atol": atol}

    def motion(self, motion):
        """The motion of the longer state."""
        n = self._n
        zeros = [0.0] * self.size

        def longer(t, z, p, *args):
            return [*motion(t, z[:n], p), *zeros]

        return longer

    def project(self):
        """The projection of the longer state; None if nothing is projected nor guarded."""
        projection = self._projection
        n = self._n
        if not self.size:
            return projection
        elements = self._elements
        moving = self._moving
        parts = self._parts
        places = self._places

        def guarded(t, z, p, *args):
            x = z[:n] if projection is None else projection(t, z[:n], p)
            now = elements(t, x, p)
            before = [*now]
            mark = z[len(z) - 1]
            for k, slot in enumerate(moving):
                before[slot] = z[n + k]
            for part in parts:
                old, new = (_matrix(each, places, *part) for each in (before, now))
                mark = np.where(_turned(old, new), 1.0, mark)
            return [*x, *[now[slot] for slot in moving], mark]

        return guarded


def _matrix(elements, places, rows, columns):
    return np.array([
        [elements[places[i, j]] if (i, j) in places else 0.0 for j in columns] for i in rows
    ])  # fmt: skip


def _turned(old, new):
    """Whether two matrices may lie on two sides of a singular one.

    With A B' = B B' (1 - E), its determinant is positive if a norm of E is below 1.
    """
    if len(new) <= LARGEST:
        return np.linalg.det(old @ new.T) <= 0.0
    change = np.linalg.solve(new @ new.T, new @ (new - old).T)
    return (change * change).sum() >= 1.0
