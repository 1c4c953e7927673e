"""Checks whether the equations determine the motion, in numbers, at states without symmetry."""

import math

import numpy as np
import sympy as sp

from fastdyn.derive.algebra import linear, shortened
from fastdyn.derive.notation import now
from fastdyn.derive.start import Residuals

RANK = 1e-9  # smallest singular value of independent equations, in rows and columns of size 1
POINTS, SEED = 3, 1  # random states for each spread: one alone may be singular by chance
SPREADS = (None, 0.3, 0.1, 0.03, 0.01, 0.0)  # about the start; None for numbers of size 1
MISSING = {
    "newton": "A constraint is missing, or a reaction is too many.",
    "lagrange": "A constraint is missing; or friction needs a normal force that is in Newton's "
    "equations alone.",
}


class Points:
    """
    States without symmetry that satisfy the constraints, with numbers for all symbols.

    Numbers of size 1 are tried first, so that no term is lost beside a larger term.  If no state
    exists for these numbers, or an expression is undefined, numbers near the defaults are taken.
    """

    def __init__(self, derivation):
        model = derivation.model
        motion = derivation.motion
        self._numbers, self._start = model.numbers, np.split(derivation.start.default, 2)
        self._inputs, self._random = len(motion.inputs), np.random.default_rng(SEED)
        numbers = [*[one.symbol for one in model.numbers], *motion.inputs]
        self.symbols = [now, *numbers, *motion.q, *motion.v]
        residuals = Residuals(motion, derivation.held, numbers)
        self.all = []
        why = ""
        dummies = dict.fromkeys((*motion.a, *derivation.laws.reactions), 1)
        whole = self._function([one.xreplace(dummies) for one in derivation.laws.candidates])
        for _ in range(POINTS):
            for spread in SPREADS:
                try:
                    there, off = self._settled(residuals, spread)
                    if not off and np.all(np.isfinite(np.array(whole(*there), float))):
                        self.all.append(there)
                        break
                    why = why or "contradict each other"
                except (ValueError, ArithmeticError) as error:
                    why = f"cannot be evaluated near the start ({error})"
            else:
                raise ValueError(
                    f"The constraints or forces of {model.name} {why}: no state is found that "
                    "satisfies them."
                )

    def _settled(self, residuals, spread):
        """A state on the constraints, with all numbers, and the remaining residuals."""
        random = self._random
        q, v = self._start
        given = [random.uniform(0.0, 1.0)]
        given += [_number(one, spread, random) for one in self._numbers]
        given += list(random.uniform(-1.0, 1.0, self._inputs))
        n = len(q)
        if spread is None:
            q = random.normal(size=n)
            v = random.normal(size=n)
        else:
            q = q + spread * _size(q) * random.normal(size=n)
            v = v + _size(v) * random.normal(size=n)
        q, v, off = residuals.settle(given, q, v, np.ones(2 * n, bool))
        return (*given, *q, *v), off

    def values(self, expressions):
        """Values of a list or Matrix of expressions at each point, as arrays."""
        function = self._function(expressions)
        return [np.array(function(*values), float) for values in self.all]

    def _function(self, expressions):
        if isinstance(expressions, sp.MatrixBase):
            expressions = expressions.tolist()
        return sp.lambdify(self.symbols, expressions, "math", cse=True)


def _size(x):
    return max(1.0, float(np.abs(x).max(initial=0.0)))


def _number(number, spread, random):
    """A random value of a parameter, of size 1 or near the default."""
    if spread is None:
        return math.exp(0.3 * random.normal()) if number.positive else random.normal()
    if number.default == 0.0:
        return 0.3 * spread * random.normal()
    return number.default * math.exp(0.3 * spread * random.normal())


def determined(derivation):
    """
    The equations K u = r that determine accelerations and reactions.

    Raises
    ------
    ValueError
        If there are too few equations, or if equations contradict each other.
    """
    _constraints_agree(derivation)
    unknowns = derivation.unknowns
    name = derivation.model.name
    held = [(one.row * sp.Matrix(derivation.motion.a))[0] - one.b for one in derivation.held]
    K, r = _linear(derivation, [law.residual for law in derivation.laws.written] + held)
    labels = [law.name for law in derivation.laws.written]
    labels += [f"the constraint `{one.name}`" for one in derivation.held]
    points = derivation.points
    ranks = [_rank(one) for one in points.values(K)]
    best = int(np.argmax(ranks))
    matrix = points.values(K)[best]
    right = points.values(r)[best].ravel()
    wrong = _contradictory(matrix, right)
    if wrong.any():
        among = ", ".join(label for label, bad in zip(labels, wrong, strict=True) if bad)
        raise ValueError(
            f"The equations of {name} contradict each other: {among}. A reaction is missing there, "
            "or a constraint is too many."
        )
    for one, column in zip(derivation.motion.q, matrix.T, strict=False):
        if not column.any():
            raise ValueError(
                f"Nothing moves with the coordinate `{one}` of {name}: no body with a mass and no "
                "constraint has it. Leave it out."
            )
    if ranks[best] < len(unknowns):
        loose = _undetermined(derivation, matrix)
        raise ValueError(
            f"The equations of {name} do not determine {loose}: there are {len(unknowns)} unknowns "
            f"and {ranks[best]} independent equations. {MISSING[derivation.law]}"
        )
    n = len(derivation.motion.q)
    candidates = derivation.laws.candidates[:n] + held + derivation.laws.candidates[n:]
    K, r = _linear(derivation, candidates)
    chosen = _independent(points.values(K)[best], len(unknowns))
    return shortened(K.extract(chosen, range(len(unknowns)))), shortened(r.extract(chosen, [0]))


def _linear(derivation, equations):
    found = linear(equations, derivation.unknowns)
    if found is None:
        raise ValueError(
            f"The reactions of {derivation.model.name} occur in its forces in other ways than as "
            "factors (an absolute value?), so the equations are not linear in them."
        )
    return found


def _constraints_agree(derivation):
    """Refuse a constraint that follows from the other constraints, or contradicts them."""
    held = derivation.held
    points = derivation.points
    if not held:
        return
    rows = points.values(sp.Matrix.vstack(*[one.row for one in held]))
    right = points.values(sp.Matrix([one.b for one in held]))
    ranks = [_rank(one) for one in rows]
    best = int(np.argmax(ranks))
    if ranks[best] == len(held):
        return
    scaled, _ = _scaled(rows[best])
    left = np.linalg.svd(scaled)[0][:, ranks[best] :]
    tied = [one.name for one, x in zip(held, left, strict=True) if np.abs(x).max() > 1e-6]
    names = " and ".join(f"`{name}`" for name in tied)
    if _contradictory(rows[best], right[best].ravel()).any():
        raise ValueError(
            f"The constraints {names} of {derivation.model.name} contradict each other: no "
            "accelerations satisfy them."
        )
    raise ValueError(
        f"The constraints {names} of {derivation.model.name} depend on each other: leave one out, "
        "or their reactions are not determined."
    )


def _scaled(matrix):
    """The matrix, its rows and columns divided by their largest entries; and the row divisors."""
    rows = np.abs(matrix).max(axis=1, keepdims=True)
    rows[rows == 0.0] = 1.0
    matrix = matrix / rows
    columns = np.abs(matrix).max(axis=0, keepdims=True)
    columns[columns == 0.0] = 1.0
    return matrix / columns, rows


def _rank(matrix):
    found = np.linalg.svd(_scaled(matrix)[0], compute_uv=False)
    return int(np.sum(found > RANK * max(found.max(initial=0.0), 1.0)))


def _contradictory(matrix, right):
    """The equations that take part in a contradiction."""
    scaled, rows = _scaled(matrix)
    right = right / rows.ravel()
    left = np.linalg.svd(scaled)[0][:, _rank(matrix) :]
    amount = left @ (left.T @ right)
    return np.abs(amount) > 1e-7 * max(np.abs(right).max(initial=0.0), 1e-300)


def _undetermined(derivation, matrix):
    """Names of the unknowns that can change without changing the equations."""
    scaled, _ = _scaled(matrix)
    loose = np.linalg.svd(scaled)[2][_rank(matrix) :]
    taken = np.abs(loose).max(axis=0) > 1e-6
    symbols = [u for u, x in zip(derivation.unknowns, taken, strict=True) if x]
    return ", ".join(str(derivation.formula.text(u)) for u in symbols)


def _independent(matrix, count):
    """The first `count` rows that do not follow from the rows before."""
    rows = _scaled(matrix)[0]
    chosen = []
    for n in range(len(rows)):
        if _rank(rows[[*chosen, n]]) == len(chosen) + 1:
            chosen.append(n)
        if len(chosen) == count:
            break
    return chosen


def kept(derivation, expression):
    """The largest rate of a quantity, and the largest term of the rate, to test for invariance."""
    motion = derivation.motion
    points = derivation.points
    K = points.values(derivation.K)
    r = points.values(derivation.r)
    state = [*motion.q, *motion.v]
    parts = [sp.diff(expression, s) for s in [*state, now, *motion.inputs]]
    worst = 0.0
    for k, right, slopes, values in zip(K, r, points.values(parts), points.all, strict=True):
        n = len(motion.q)
        speeds = np.array(values[-n:])
        accelerations = np.linalg.solve(k, right.ravel())[:n]
        rates = np.concatenate([speeds, accelerations, np.ones(1 + len(motion.inputs))])
        terms = slopes * rates
        size = np.abs(terms).max(initial=0.0)
        if size:
            worst = max(worst, abs(terms.sum()) / size)
    return worst


def singular(points, matrix):
    """Whether a matrix is singular at states without symmetry."""
    return max(map(_rank, points.values(matrix))) < matrix.rows
