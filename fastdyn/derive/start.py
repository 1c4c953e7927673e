"""States on the constraints: Newton's iteration finds the components that are not given."""

from typing import Any

import numpy as np
import sympy as sp

from .code import function, real_text
from .notation import now

ITERATIONS = 60  # at a double root each halves the error: 53 reach rounding
ROUNDING = 1e-12  # residual that counts as zero, relative to its largest term


class Residuals:
    """
    Residuals of the constraints and their derivatives, as functions of numbers.

    Parameters
    ----------
    motion : Motion
    held : list of Held
    numbers : list of Symbol
        Parameters, and all other symbols in the constraints.
    """

    def __init__(self, motion, held, numbers):
        self.n = len(motion.q)
        self.held = held
        self.positions = [one for one in held if one.position is not None]
        arguments = [now, *numbers, *motion.q, *motion.v]
        self._position = _residuals(arguments, [one.position for one in self.positions], motion.q)
        self._velocity = _residuals(arguments, [one.velocity for one in held], motion.v)

    def settle(self, numbers, q, v, free):
        """
        The state near (q, v) that satisfies the constraints, and the remaining residuals.

        Parameters
        ----------
        numbers : sequence of float
            t, then the numbers, but for q and v.
        q, v : ndarray, shape (n,)
        free : ndarray of bool, shape (2 n,)
            Which components of the state may change.

        Returns
        -------
        q, v : ndarray
        off : dict of str to float
            Residuals that remain, by name.
        """
        q, v, n, off = np.array(q, float), np.array(v, float), self.n, {}
        if self.positions:
            q, left = _newton(lambda q: self._position(*numbers, *q, *v), q, free[:n])
            off |= _by_name([one.name for one in self.positions], left)
        if self.held:
            v, left = _newton(lambda v: self._velocity(*numbers, *q, *v), v, free[n:])
            names = [one.name if one.position is None else f"{one.name}_rate" for one in self.held]
            off |= _by_name(names, left)
        return q, v, off


def _residuals(arguments, expressions, variables) -> Any:
    """A function that gives residuals, their Jacobian, and the size of the terms of each."""
    if not expressions:
        return None
    jacobian = sp.Matrix(expressions).jacobian(variables)
    function = sp.lambdify(arguments, [expressions, jacobian.tolist()], "math", cse=True)

    def evaluated(*numbers):
        value, rows = (np.array(part, float) for part in function(*numbers))
        return value, rows

    return evaluated


def _newton(function, x, free):
    """Newton's iteration with steps of least length; returns x and the remaining residuals."""
    value, rows = function(x)
    for _ in range(ITERATIONS):
        size = np.abs(rows) @ np.abs(x) + np.abs(value)
        if np.all(np.abs(value) <= ROUNDING * size) or not free.any():
            break
        step = np.linalg.lstsq(rows[:, free], -value, rcond=1e-10)[0]
        for shorter in 0.5 ** np.arange(8):
            tried = x.copy()
            tried[free] += shorter * step
            value_there, rows_there = function(tried)
            if np.linalg.norm(value_there) < np.linalg.norm(value):
                break
        else:
            break
        x = tried
        value = value_there
        rows = rows_there
    size = np.abs(rows) @ np.abs(x) + np.abs(value)
    return x, np.where(np.abs(value) > 1e3 * ROUNDING * size, value, 0.0)


def _by_name(names, left):
    return {name: float(x) for name, x in zip(names, left, strict=True) if x != 0.0}


class Start:
    """
    The state at t = 0: given components, and components that the constraints determine.

    Parameters
    ----------
    model : Model
    motion : Motion
    held : list of Held

    Attributes
    ----------
    default : ndarray, shape (2 n,)
        The state for the defaults of all numbers.
    """

    def __init__(self, model, motion, held):
        self.name = model.name
        self._gives = [one.gives for one in model.drivers]
        self._inputs = [str(one) for one in motion.inputs]
        self._senses = [str(one) for one in motion.senses]
        self.names = [str(one) for one in (*motion.q, *motion.v)]
        self._free = np.array([name not in model.given for name in self.names])
        numbers = [one.symbol for one in model.numbers]
        values = model.guesses | model.given
        self.expressions = [motion.symbols(values.get(name, 0)) for name in self.names]
        for name, one in zip(self.names, self.expressions, strict=True):
            if unknown := one.free_symbols - set(numbers):
                raise ValueError(
                    f"The start of `{name}` of {self.name} depends on {min(map(str, unknown))}, "
                    "which is none of its numbers."
                )
        lines = [f"return [{', '.join(map(real_text, self.expressions))}]"]
        self._begin = function("start", [str(one) for one in numbers], lines, arrays=True)
        self._residuals = Residuals(motion, held, [*numbers, *motion.inputs]) if held else None
        defaults = [one.default for one in model.numbers], [one.default for one in model.drivers]
        self.default = np.array(self.state(*defaults), float)

    def state(self, numbers, drivers):
        """
        The state at t = 0 as a list.

        Parameters
        ----------
        numbers : sequence of float
            All numbers of the model, in order; arrays are allowed without constraints.
        drivers : sequence of callable

        Raises
        ------
        ValueError
            If the given components violate the constraints.
        """
        begin = self._begin(*numbers)
        if self._residuals is None:
            return begin
        begin = np.array([float(one) for one in begin])  # one state at a time
        state, off = self.settled(0.0, begin, numbers, drivers, self._free)
        if off:
            parts = " and ".join(f"`{name}` (by {value:.3g})" for name, value in off.items())
            raise ValueError(
                f"The start of {self.name} violates {parts}, and no values of the other components "
                "satisfy the constraints: the constraints or the given values contradict each "
                "other, or the search begins too far away. Let `guess(...)` name values near the "
                "start; without a guess the search begins at 0."
            )
        return state.tolist()

    def parts(self, drivers):
        """
        What `state` computes, as functions of (t, state, *numbers) that can be traced.

        Returns
        -------
        callable, list of (callable, int, list of bool, int)
            The components before the constraints hold; for positions and velocities the residuals
            with their Jacobian behind, their number, which components are free, the first of these.
        """
        found = []
        residuals = self._residuals
        n = len(self.names) // 2

        def begin(t, state, *numbers):
            return self._begin(*numbers)

        def known(t, state, numbers):
            given: dict[str, Any] = dict.fromkeys(self._senses, 1.0)
            for driver, names in zip(drivers, self._gives, strict=True):
                given |= dict(zip(names, driver(t, state), strict=True))
            return [t, *numbers, *(given[name] for name in self._inputs), *state]

        if residuals is not None:
            sides = ((residuals._position, len(residuals.positions), 0),)
            sides += ((residuals._velocity, len(residuals.held), n),)
            for function, count, first in sides:

                def part(t, state, *numbers, function=function):
                    value, rows = function(*known(t, state, numbers))
                    return np.concatenate([value, np.ravel(rows)])

                if count:
                    found.append((part, count, self._free[first : first + n].tolist(), first))
        return begin, found

    def settled(self, t, state, numbers, drivers, free) -> Any:
        """The state on the constraints near a state, and the remaining residuals, by name."""
        if self._residuals is None:
            return np.asarray(state, float), {}
        given: dict[str, Any] = dict.fromkeys(self._senses, 1.0)
        for driver, names in zip(drivers, self._gives, strict=True):
            given |= dict(zip(names, np.atleast_1d(driver(t, state)), strict=True))
        known = [t, *numbers, *(given[name] for name in self._inputs)]
        n = len(state) // 2
        q, v, off = self._residuals.settle(known, state[:n], state[n:], free)
        return np.concatenate([q, v]), off
