"""Replaces functions of time by plain symbols, and differentiates them by the chain rule."""

import itertools

import sympy as sp
from sympy.core.function import AppliedUndef

from .notation import now, t, with_one_time


class Motion:
    """
    Coordinates, rates, accelerations, reactions and the functions of drivers, as plain symbols.

    Attributes
    ----------
    q, v, a : list of Symbol
        Coordinates, rates, accelerations.
    reactions, inputs : list of Symbol
        Reactions; and the functions of drivers, their rates, and the `senses`.
    senses : list of Symbol
        Symbols with the value 1 or -1: see `friction.Contact`.
    plain : dict
        The symbol of each function of time and each of its derivatives.
    """

    def __init__(self, coordinates, inputs, reactions, senses=()):
        self.q = [sp.Symbol(one.name, real=True) for one in coordinates]
        self.v = [sp.Symbol(one.rate, real=True) for one in coordinates]
        self.a = [sp.Symbol(f"{one.name}_dd", real=True) for one in coordinates]
        self.reactions = [sp.Symbol(one.name, real=True) for one in reactions]
        self.senses, self.inputs = list(senses), list(senses)
        self.plain, self._next, self._last = {}, {}, set()
        for one, *chain in zip(coordinates, self.q, self.v, self.a, strict=True):
            self._chain(one.function, chain)
        for one in inputs:
            chain = [sp.Symbol(s, real=True) for s in one.symbols]
            self._chain(one.function, chain)
            self.inputs += chain
        for one, symbol in zip(reactions, self.reactions, strict=True):
            self._chain(one.function, [symbol])

    def _chain(self, function, symbols):
        """Map a function of time and its derivatives to symbols, one for each derivative."""
        self.plain |= {_derivative(function, n): s for n, s in enumerate(symbols)}
        self._next |= dict(itertools.pairwise(symbols))
        self._last.add(symbols[-1])

    def symbols(self, expression):
        """An expression with plain symbols instead of functions of time.

        Functions with equal names become one symbol.
        """
        expression = with_one_time(expression)
        functions = {f for f in self.plain if isinstance(f, AppliedUndef)}
        ours = {f.func.__name__: f for f in functions}
        theirs = expression.atoms(AppliedUndef) - functions
        same = {f: ours[f.func.__name__] for f in theirs if _is_of_time(f, ours)}
        return with_one_time(expression.xreplace(same).xreplace(self.plain), now)

    def rate(self, expression):
        """Derivative with respect to time of an expression of plain symbols."""
        if isinstance(expression, sp.MatrixBase):
            return expression.applyfunc(self.rate)
        total = sp.diff(expression, now)
        for symbol in sorted(expression.free_symbols, key=str):
            if symbol in self._next:
                total += sp.diff(expression, symbol) * self._next[symbol]
            elif symbol in self._last:
                raise ValueError(
                    f"the equations need the rate of {self.functions(symbol)}, which nothing "
                    "gives; a driver must return the rate, too, of what it returns."
                )
        return total

    def functions(self, expression):
        """An expression with functions of time instead of plain symbols: undoes `symbols`."""
        return expression.xreplace({symbol: f for f, symbol in self.plain.items()})


def _is_of_time(function, names):
    """Whether a function depends on t alone, and has one of the names."""
    return function.func.__name__ in names and function.args == (t,)


def _derivative(function, order):
    return sp.Derivative(function, (t, order)) if order else function
