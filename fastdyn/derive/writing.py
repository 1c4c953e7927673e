"""Writes the functions of a system as Python text, with common parts computed once."""

import itertools
from typing import Any

import sympy as sp

from .code import function, real_text

STEPS = 3  # Newton steps in a projection, enough to reduce errors of 1e-2 to rounding


class Writer:
    """
    Writes functions of ``(t, w, *parameters)``; w has another name if a number is called w.

    Parameters
    ----------
    derivation : Derivation
    senses : dict of str to float
        The senses of the slipping contacts, by default 1: see `friction.Contact`.
    beside : sequence of str
        Names of further components of the state.
    """

    def __init__(self, derivation, senses=None, beside=()):
        model = derivation.model
        motion = derivation.motion
        self.motion = motion
        self.held = derivation.held
        self.state = [*motion.q, *motion.v]
        parameters = [str(one.symbol) for one in model.numbers if not one.initial]
        given = [*parameters, *(one.name for one in model.drivers)]
        known = {*given, *map(str, (*self.state, *motion.inputs, *derivation.unknowns)), *beside}
        self._whole = next(name for name in ("w", "state", "whole_state") if name not in known)
        self.arguments = ["t", self._whole, *given]
        self._senses = dict.fromkeys(map(str, motion.senses), 1.0) | (senses or {})
        self._beside = list(beside)
        self._drivers = [(one.name, one.gives) for one in model.drivers]
        self._step = {u: step for step in derivation.steps for u in step.unknowns}
        self._names = {*self.arguments, *map(str, (*self.state, *motion.inputs))}
        self._names |= {str(one) for one in derivation.unknowns}

    def number(self, name, expression, arrays=True):
        """A function that returns a number; it takes arrays if no system has to be solved."""
        lines, (text,) = self.body([expression])
        arrays = arrays and not any("solve_linear" in line for line in lines)
        return function(name, self.arguments, [*lines, f"return {text}"], arrays)

    def numbers(self, name, expressions, given="[{}]".format):
        """A function that returns several numbers, as a list, or in the format `given`."""
        lines, results = self.body(expressions)
        return function(name, self.arguments, [*lines, f"return {given(', '.join(results))}"])

    def rhs(self, beside=()):
        """The right-hand side; `beside` are the rates of the further components."""
        return self.numbers("rhs", [*self.motion.v, *self.motion.a, *beside])

    def body(self, results):
        """Lines that compute common parts, and the texts of the results in these parts."""
        steps = self._needed(results)
        parts, short = self._shared([*itertools.chain(*(s.needs for s in steps)), *results])
        brief = iter(short)
        needs = {step.unknowns[0]: [next(brief) for _ in step.needs] for step in steps}
        results, order, known = list(brief), [], set()

        def need(expressions):
            """Append the steps that expressions need, in the order of evaluation."""
            for symbol in sorted(set().union(*(e.free_symbols for e in expressions)), key=str):
                if symbol in known:
                    continue
                known.add(symbol)
                if symbol in parts:
                    need([parts[symbol]])
                    order.append(([symbol], [parts[symbol]]))
                elif symbol in self._step:
                    unknowns = self._step[symbol].unknowns
                    known.update(unknowns)
                    need(needs[unknowns[0]])
                    order.append((unknowns, needs[unknowns[0]]))

        need(results)
        lines = self._given([*short, *parts.values()])
        names = [one for unknowns, _ in order for one in unknowns if one in parts]
        names = dict(zip(names, self._numbered(), strict=False))
        for unknowns, given in order:
            given = [one.xreplace(names) for one in given]
            if len(given) == 1:
                lines.append(f"{names.get(unknowns[0], unknowns[0])} = {real_text(given[0])}")
            else:
                lines.append(_elimination(unknowns, given))
        return lines, [real_text(result.xreplace(names)) for result in results]

    def _needed(self, results):
        """The steps that results need."""
        todo = list(results)
        seen = set()
        steps = {}
        while todo:
            for symbol in todo.pop().free_symbols - seen:
                seen.add(symbol)
                if symbol in self._step and id(self._step[symbol]) not in steps:
                    steps[id(self._step[symbol])] = self._step[symbol]
                    todo += self._step[symbol].needs
        return list(steps.values())

    def _numbered(self):
        """Names for common parts."""
        names = (f"c{n}" for n in itertools.count(1))
        return (sp.Symbol(name) for name in names if name not in self._names)

    def _shared(self, expressions):
        """Common parts by name, and the expressions with these names inserted."""
        found: Any
        short: Any
        found, short = sp.cse(list(expressions), symbols=self._numbered(), order="none")
        parts = {}
        signs = {}
        for symbol, part in found:
            part = part.xreplace(signs)
            if (-part).is_Symbol:  # not worth a name
                signs[symbol] = part
            else:
                parts[symbol] = part
        return parts, [one.xreplace(signs) for one in short]

    def _given(self, expressions):
        """Lines that unpack the state, and ask the drivers."""
        lines = [self._unpacked()]
        own = self._whole
        own += f"[:{len(self.state)}]" if self._beside else ""
        used = set().union(*(one.free_symbols for one in expressions))
        for name, gives in self._drivers:
            if used & {sp.Symbol(one, real=True) for one in gives}:
                lines.append(f"{', '.join(gives)}{',' * (len(gives) == 1)} = {name}(t, {own})")
        used = set(map(str, used))
        return lines + [f"{name} = {one}" for name, one in self._senses.items() if name in used]

    def _unpacked(self):
        """The line that names the components of the state."""
        return f"{', '.join([*map(str, self.state), *self._beside])} = {self._whole}"

    def project(self, metric):
        """
        The function that moves a state to the nearest state on the constraints.

        Parameters
        ----------
        metric : Matrix
            The masses, which measure distances.
        """
        on_positions = [one for one in self.held if one.position is not None]
        q = self.motion.q
        v = self.motion.v
        lines = [self._unpacked()]
        known = []
        if on_positions:
            residuals = sp.Matrix([one.position for one in on_positions])
            step = self._shift(metric, residuals.jacobian(q), residuals, q)
            lines += [f"for _ in range({STEPS}):", *(f"    {line}" for line in step)]
        residuals = sp.Matrix([one.velocity for one in self.held])
        known = self._given([*metric, *residuals])[1:]
        rows = residuals.jacobian(v)
        step = self._shift(metric, rows, residuals, v)
        if rows.free_symbols & {*v}:
            step = [f"for _ in range({STEPS}):", *(f"    {line}" for line in step)]
        lines += known + step
        if known and on_positions:
            lines[1:1] = known
        lines.append(f"return [{', '.join([*map(str, self.state), *self._beside])}]")
        return function("project", self.arguments, lines)

    def _shift(self, metric, rows, residuals, moved):
        """Lines that take the shortest step to a zero of linear residuals."""
        n = len(moved)
        count = len(residuals)
        parts, short = self._shared([*metric, *rows, *residuals])
        mass = short[: n * n]
        rows = short[n * n : -count]
        off = short[-count:]
        text = [f"{name} = {real_text(part)}" for name, part in parts.items()]
        steps = ", ".join([*(f"d_{one}" for one in moved), *["_"] * count])
        blocks = [_rows(mass, n), _rows(rows, n), _tuple([sp.S.Zero] * n), _tuple(off)]
        text.append(f"{steps} = constrained({', '.join(blocks)})")
        return text + [f"{one} = {one} - d_{one}" for one in moved]


def _elimination(unknowns, entries):
    """The line that solves linear equations; `entries` are those of matrix and right-hand side."""
    n = len(unknowns)
    names = f"{unknowns[0]}," if n == 1 else ", ".join(map(str, unknowns))
    return f"{names} = solve_linear({_rows(entries[: n * n], n)}, {_tuple(entries[n * n :])})"


def _rows(entries, n):
    return _together([_tuple(entries[k : k + n]) for k in range(0, len(entries), n)])


def _tuple(entries):
    return _together([real_text(one) for one in entries])


def _together(texts):
    return f"({texts[0]},)" if len(texts) == 1 else f"({', '.join(texts)})"
