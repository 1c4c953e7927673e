"""`isinstance` on symbols."""

import numbers

import numpy as np

from ..graph.kinds import INT
from .complex_pair import Pair
from .real import Symbol
from .symbolic import Symbolic, refuse


def of_type(value, kinds):
    """isinstance(value, kinds); a symbol is an instance of the type that the symbol stands for."""
    if not isinstance(value, Symbolic):
        return isinstance(value, kinds)
    kinds = kinds if isinstance(kinds, tuple) else (kinds,)
    if isinstance(value, Pair):
        known = (complex, np.complexfloating, np.complex128, np.number, np.generic, object)
        return any(getattr(k, "plain", k) in known or k is numbers.Complex for k in kinds)
    if not isinstance(value, Symbol):
        known = (bool, int) if getattr(value, "python", False) else (np.bool_, np.generic)
        return any(getattr(k, "plain", k) in (*known, object) for k in kinds)
    whole = value.kind == INT
    if whole and len({int, np.integer}.intersection(getattr(k, "plain", k) for k in kinds)) == 1:
        refuse("it asks whether a whole number is Python's or NumPy's")
    known = (int, np.integer) if whole else (float, np.floating, np.float64)
    known += (object, np.number, np.generic)
    abstract = ("Number", "Complex", "Real", "Rational", "Integral")[: 5 if whole else 3]
    return any(
        getattr(k, "plain", k) in known or (k.__module__ == "numbers" and k.__name__ in abstract)
        for k in kinds
    )
