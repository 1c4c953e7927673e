"""Whether equations F(t, y, y') = 0 are of index 1 at a state; the sentences where they are not.

K. E. Brenan, S. L. Campbell and L. R. Petzold, "Numerical Solution of Initial-Value Problems in
Differential-Algebraic Equations", SIAM 1996, chapter 2: the pencil dF/dy + c dF/dy' is of index 1
if dF/dy determines the part of the state whose derivatives do not occur.
"""

import numpy as np

SHOWN = 5  # names in a sentence
SHARE = 0.3  # of the largest number of a null vector: what counts
SMALL_STEP, RATIO = 1e-6, 8.0  # the larger step, in units of |dF/dy'| / |dF/dy|; both steps
SHIFTS = (0.71, 1.93, -3.07)  # a regular pencil is singular for few values, hardly for all of these


class HighIndexError(ValueError):
    """Equations whose index is above 1."""


def not_reduced(found, why):
    """The HighIndexError of equations that cannot be differentiated, with the cause first."""
    return HighIndexError(f"{why} Such equations must be differentiated. {found}")


def check_structure(pattern, n):
    """Raise ValueError if no choice of elements gives each equation a component of its own."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import maximum_bipartite_matching

    rows, columns = pattern.entries
    matrix = csr_matrix((np.ones(len(rows)), (rows, columns)), (n, n))
    match = np.asarray(maximum_bipartite_matching(matrix, perm_type="column"))
    if (match >= 0).all():
        return
    missing = np.setdiff1d(np.arange(n), match[match >= 0])
    absent = np.setdiff1d(missing, columns)
    if absent.size:
        occurs = "occurs" if absent.size == 1 else "occur"
        said = f"{names('component', absent)} {occurs} in no equation"
    else:
        has = "has" if np.sum(match < 0) == 1 else "have"
        said = (
            f"{names('equation', np.flatnonzero(match < 0))} {has} no unknown that the other "
            f"equations leave over, and nothing determines {names('component', missing)}"
        )
    raise ValueError(f"The equations are structurally singular: {said}.")


def check_index(jacobian, n, noise):
    """Raise ValueError unless the equations with a full Jacobian (n, 2 n) are of index 1."""
    B = jacobian[:, :n]
    A = jacobian[:, n:]
    left, right = null_spaces(jacobian, n, noise)
    core, terms = (f(left).T @ f(B) @ f(right) for f in (np.asarray, np.abs))
    found = _null(np.where(np.abs(core) <= n * noise * terms, 0.0, core), n * noise)
    if found is None:
        return
    equations = _largest(left @ found[0])
    components = _largest(right @ found[1])
    if all(_null(B + c * A, n * noise) is not None for c in SHIFTS):
        raise ValueError(
            f"The equations are singular: {names('equation', equations)} and "
            f"{names('component', components)} do not determine each other (two equations say the "
            "same, or a component occurs in none)."
        )
    raise HighIndexError(
        f"The index of the equations is above 1: {names('equation', equations)} "
        f"{'does' if len(equations) == 1 else 'do'} not determine "
        f"{names('component', components)}."
    )


def null_spaces(jacobian, n, noise):
    """Combinations of equations without derivatives, and of components whose derivatives do not
    occur: matrices (n, k), of columns.
    """
    B = jacobian[:, :n]
    A = jacobian[:, n:]
    rows = 1.0 / _or_one(np.abs(A).max(axis=1), np.abs(B).max(axis=1))
    columns = 1.0 / _or_one(np.abs(rows[:, None] * A).max(axis=0))
    left, sizes, right = np.linalg.svd(rows[:, None] * A * columns)
    rank = int(np.sum(sizes > n * noise * sizes[0])) if sizes[0] else 0
    return rows[:, None] * left[:, rank:], columns[:, None] * right[rank:].T


def check_large_index(jacobian, n):
    """`check_index` for many equations, by the growth of (dF/dy' + h dF/dy)^-1 as h falls.

    The inverse grows as h^-index.
    """
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    jacobian = csc_matrix(jacobian)
    if not np.isfinite(jacobian.data).all():
        return
    B = jacobian[:, :n]
    A = jacobian[:, n:]
    scale = abs(A).max() / (abs(B).max() or 1.0)
    v = np.random.default_rng(0).uniform(0.5, 1.0, n)
    sizes = []
    for h in (SMALL_STEP * scale, SMALL_STEP * scale / RATIO):
        try:
            sizes.append(np.abs(splu((A + h * B).tocsc()).solve(v)).max())
        except RuntimeError:
            raise ValueError(
                "The equations are singular: two say the same, or a component occurs in none."
            ) from None
    if sizes[1] > RATIO**1.5 * sizes[0]:
        raise HighIndexError(
            "The index of the equations is above 1: constraints do not determine the algebraic "
            "components."
        )


def index_of(jacobian, n, noise, rates):
    """The index, 0 or 1, of equations that passed the check.

    `rates` marks the components whose derivatives occur; that decides for large equations.
    """
    if isinstance(jacobian, np.ndarray):
        return int(null_spaces(jacobian, n, noise)[0].shape[1] > 0)
    return int(not rates.all())


def large_rates(jacobian, n, rate, by_time):
    """y' by a step of Euler's implicit method, so short that y' changes where F leaves it open."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    jacobian = csc_matrix(jacobian)
    B = jacobian[:, :n]
    A = jacobian[:, n:]
    h = SMALL_STEP * abs(A).max() / (abs(B).max() or 1.0)
    return splu((A + h * B).tocsc()).solve(A @ rate - h * by_time)


def names(kind, numbers):
    """Words for equations or components: "equation 2", "components y[0], y[1]"."""
    said = [f"y[{i}]" if kind == "component" else str(i) for i in numbers[:SHOWN]]
    more = f" and {len(numbers) - SHOWN} more" if len(numbers) > SHOWN else ""
    return f"{kind}{'s' if len(numbers) > 1 else ''} {', '.join(said)}{more}"


def _or_one(sizes, others=None):
    sizes = np.where(sizes > 0.0, sizes, 1.0 if others is None else others)
    return np.where(sizes > 0.0, sizes, 1.0)


def _null(matrix, noise):
    """A left and a right null vector of a square matrix; None if the matrix is regular."""
    if not matrix.size:
        return None
    rows = 1.0 / _or_one(np.abs(matrix).max(axis=1))
    columns = 1.0 / _or_one(np.abs(rows[:, None] * matrix).max(axis=0))
    left, sizes, right = np.linalg.svd(rows[:, None] * matrix * columns)
    if sizes[-1] > noise * sizes[0]:
        return None
    return rows * left[:, -1], columns * right[-1]


def _largest(vector):
    """The indices of the numbers that count in a vector."""
    sizes = np.abs(vector)
    return np.flatnonzero(sizes >= SHARE * sizes.max())
