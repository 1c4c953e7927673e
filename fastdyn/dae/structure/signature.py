"""Which equations have to be differentiated, and how often.

J. D. Pryce, "A simple structural analysis method for DAEs", BIT 41 (2001) 364: an assignment of
components to equations, and the smallest dual of the assignment.  The counts are those of C. C.
Pantelides, "The consistent initialization of differential-algebraic systems", SIAM J. Sci. Stat.
Comput. 9 (1988) 213 (Pryce, section 5).
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from fastdyn.trace.graph.derivatives import jacobian

ABSENT = -1  # in a signature: the component is not in the equation


class Offsets(NamedTuple):
    """How often each equation is differentiated, and the highest order of each component."""

    equations: np.ndarray
    components: np.ndarray

    @property
    def structural_index(self):
        """The index that the structure tells."""
        return int(self.equations.max() + (self.components.min() == 0))

    @property
    def freedom(self):
        """The number of states."""
        return int(self.components.sum() - self.equations.sum())


def signature(given):
    """The highest order of each component in each equation; ABSENT where there is none."""
    orders = 1 + max([1, *(order + 1 for _, order in given.alias.values())])
    rows, places, _ = jacobian(given.graph, given.outputs, orders * given.n)
    found = np.full((len(given.outputs), given.n), ABSENT)
    levels, columns = np.divmod(places, given.n)
    np.maximum.at(found, (rows, columns), levels)
    return found[:, given.columns]


def offsets(sigma, rows, columns):
    """The Offsets of a signature.

    `rows` and `columns` number the equations and the components for a message.

    Raises
    ------
    ValueError
        If the structure is singular.
    """
    present = sigma != ABSENT
    matched = maximum_bipartite_matching(csr_array(present), perm_type="column")
    if (matched < 0).any():
        raise ValueError(_singular(present, matched, rows, columns))
    size = len(sigma)
    never = -(size + 1.0) * (1 + sigma.max(initial=0))
    at, of = linear_sum_assignment(np.where(present, sigma, never), maximize=True)
    c = np.zeros(size, int)
    while True:
        d = np.where(present, sigma + c[:, None], ABSENT).max(axis=0, initial=0)
        new = d[of] - sigma[at, of]
        if (new == c).all():
            return Offsets(c, d)
        c = new


def _singular(present, matched, rows, columns):
    """A sentence that names equations with too few components (Dulmage and Mendelsohn)."""
    todo = [int(np.flatnonzero(matched < 0)[0])]
    equations = set(todo)
    components = set()
    owner = {int(j): i for i, j in enumerate(matched) if j >= 0}
    while todo:
        for j in np.flatnonzero(present[todo.pop()]):
            if j not in components:
                components.add(int(j))
                if owner[int(j)] not in equations:
                    equations.add(owner[int(j)])
                    todo.append(owner[int(j)])
    free = sorted(set(range(len(columns))) - {int(j) for j in matched})
    many = sorted(rows[i] for i in equations)
    some = sorted(columns[j] for j in components)
    inside = f"only the components {some} of y or yp" if some else "no component of y or yp"
    plural = "equations" if len(many) > 1 else "equation"
    left = ", ".join(str(columns[j]) for j in free)
    return (
        f"the system is structurally singular: {plural} {', '.join(map(str, many))} (counted from "
        f"0) contain{'' if len(many) > 1 else 's'} {inside}, and nothing determines component "
        f"{left}."
    )
