"""`solve_linear` and `constrained` on symbols, by the same elimination as on numbers."""

import numpy as np

from fastdyn.kernels.algebra import constrained as motion
from fastdyn.kernels.algebra import linear
from fastdyn.trace.functions.linear_systems import scaled_solution
from fastdyn.trace.functions.stand_ins import STAND_INS
from fastdyn.trace.functions.ufuncs import as_numpy
from fastdyn.trace.symbols.lift import number, symbol
from fastdyn.trace.symbols.symbol import Symbol, graph_of, is_symbolic


def _under_numpys_rules(given):
    """Convert numbers in nested lists to numbers by NumPy's rules: no operation on them raises."""
    if isinstance(given, np.ndarray | list | tuple):
        return [_under_numpys_rules(v) for v in given]
    value = number(given)
    return as_numpy(value) if isinstance(value, Symbol) else float(value)


def _eliminated(rows):
    """`linear.eliminated` on symbols; more than LONGEST rows in a loop."""
    g = graph_of(*rows)
    if len(rows) <= linear.LONGEST or g is None:
        return linear.eliminated(rows)
    whole = symbol(g, rows)
    return scaled_solution(whole[:, :-1], whole[:, -1])


def _stand_in(function, formula, message):
    def on_symbols(*given):
        if not is_symbolic(given):
            return function(*given)
        x, regular = formula(*map(_under_numpys_rules, given), eliminate=_eliminated)
        if isinstance(regular, Symbol):
            g = regular.g
            g.raises_if(g.negation(regular.node), linear.SingularMatrixError)
        elif not regular:
            raise linear.SingularMatrixError(message)
        return tuple(x)

    return on_symbols


def stand_in():
    """Register the stand-ins of both functions."""
    for function, *how in (
        (linear.solve_linear, linear.linear_solved, linear.SINGULAR),
        (motion.constrained, motion.constraints_solved, motion.CONTRADICTORY),
    ):
        STAND_INS[id(function)] = _stand_in(function, *how)
