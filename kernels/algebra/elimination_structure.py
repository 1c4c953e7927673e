"""The places in the factors of a matrix that may be nonzero, for every choice of pivots."""

from typing import NamedTuple

MOST_PRODUCTS = 1360  # most products in straight-line code: products of a full matrix of 16 rows


class Structure(NamedTuple):
    """The places in the factors of a matrix that may be nonzero, for every choice of pivots.

    `below[k]` has the rows, below the diagonal, of the elements in column k of L; `right[k]` has
    the columns of the elements in row k of U; `places` maps (row, column) to the storage.
    """

    below: tuple
    right: tuple
    places: dict

    @property
    def n_products(self):
        """Products of a factorisation."""
        pairs = zip(self.below, self.right, strict=True)
        return sum(len(below) * (1 + len(right)) for below, right in pairs)


def structure(places, n):
    """The Structure of matrices with a diagonal and elements in these places, (row, column).

    All rows that may become row k get the union of their elements: A. George and E. Ng, "Symbolic
    factorization for sparse Gaussian elimination with partial pivoting", SIAM J. Sci. Stat.
    Comput. 8 (1987) 877-898.
    """
    known = [{i} for i in range(n)]
    for i, j in places:
        known[i].add(j)
    below = []
    right = []
    for k in range(n):
        candidates = [i for i in range(k, n) if k in known[i]]
        together = {j for i in candidates for j in known[i] if j >= k}
        for i in candidates:
            known[i] |= together
        below.append(tuple(candidates[1:]))
        right.append(tuple(sorted(together - {k})))
    elements = [(i, j) for i, row in enumerate(known) for j in sorted(row)]
    return Structure(tuple(below), tuple(right), {e: at for at, e in enumerate(elements)})
