"""Equations of motion with constraints: accelerations and reactions together."""

from .linear import eliminated, in_python, largest, quotient

CONTRADICTORY = (
    "the equations of motion are singular: the constraints do not determine the accelerations "
    "and reactions (are they written for the accelerations, and independent of each other?)"
)


def constrained(mass, a, force, b):
    """Accelerations and reactions of a system with constraints.

    Solves M q'' - A^T R = f and A q'' = b.  Each constraint is differentiated until it contains the
    accelerations, and gives a row of A.  Each constraint has one reaction, along this row.

    Parameters
    ----------
    mass : tuple of n numbers, or of n tuples of n numbers
        The masses, all positive; or the rows of M, which may be singular (a massless part).
    a : tuple of k tuples of n numbers
        Rows of A.
    force : tuple of n numbers
        Applied forces f.
    b : tuple of k numbers
        The right-hand sides of A q'' = b.

    Returns
    -------
    tuple of n + k floats
        The accelerations q'', then the reactions R.

    Raises
    ------
    SingularMatrixError
        If accelerations and reactions are not determined: constraints depend on each other, or do
        not restrict the accelerations.

    Notes
    -----
    With b minus the residual and no force, the first n numbers are the smallest displacement,
    measured by the masses, that removes the residual: this is how a state is projected onto
    constraints.
    """
    return in_python(constraints_solved, CONTRADICTORY, mass, a, force, b)


def _dot(x, y):
    total = x[0] * y[0]
    for p, q in zip(x[1:], y[1:], strict=True):
        total = total + p * q
    return total


def constraints_solved(mass, a, force, b, eliminate=None):
    eliminate = eliminate or eliminated
    n = len(force)
    k = len(b)
    if any(len(row) != n for row in a) or len(a) != k or len(mass) != n:
        raise ValueError(
            f"{n} forces and {k} right-hand sides need {n} masses and A with {k} rows of {n} "
            f"numbers; got {len(mass)} masses and {len(a)} rows of {[len(row) for row in a]}."
        )
    if isinstance(mass[0], list):
        if any(len(row) != n for row in mass):
            raise ValueError(f"{n} forces need {n} masses, or M with {n} rows of {n} numbers")
        size = largest([x for row in mass for x in row])  # the unknowns are reactions / size
        rows = [
            [*m, *(0.0 - size * a[i][j] for i in range(k)), force[j]] for j, m in enumerate(mass)
        ]
        rows += [[*row, *[0.0] * k, r] for row, r in zip(a, b, strict=True)]
        x, regular = eliminate(rows)
        return [*x[:n], *(size * r for r in x[n:])], regular
    per_mass = [[quotient(x, m) for x, m in zip(row, mass, strict=True)] for row in a]
    rows = [
        [*(_dot(row, other) for other in a), r - _dot(row, force)]
        for row, r in zip(per_mass, b, strict=True)
    ]
    reactions, regular = eliminate(rows)
    total = list(force)
    for row, r in zip(a, reactions, strict=True):
        total = [f + x * r for f, x in zip(total, row, strict=True)]
    return [*(quotient(f, m) for f, m in zip(total, mass, strict=True)), *reactions], regular
