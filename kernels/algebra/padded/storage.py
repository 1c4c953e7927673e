"""The memory of a matrix of n rows, which a whole number of vectors holds.

The matrix is enlarged to ``leading(n)`` rows and columns by those of the identity, and stored by
columns: element (i, j) is number ``j leading(n) + i``.  A right-hand side is enlarged by zeros.
"""

WIDTH = 4
# Kinds of matrices.  Rows of a scaled matrix are divided by their largest element.
GENERAL = 0
SYMMETRIC = 1
SCALED = 2


def leading(n):
    """The rows of the enlarged matrix, which are the distance between columns."""
    return -(-n // WIDTH) * WIDTH


def length(n):
    """The numbers of the enlarged matrix."""
    return leading(n) ** 2
