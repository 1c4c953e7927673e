"""An exercise: its question, its names with units, and the terms of its reference."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

STATES = 60  # number of random states at which equations are compared
POSITIVE = (0.5, 2.0)  # the range of a parameter


class Exercise(NamedTuple):
    """
    An exercise.

    Parameters
    ----------
    name : str
        The name of the function that a student writes.
    question : str
    state : dict of str to str
        Names of the components of the state, and their units.
    parameters : dict of str to str
        Names of the arguments after the state, and their units; their values are positive.
    answer : dict of str to str
        Names of the results of the function, and their units.
    terms : dict of str to dict of str to callable
        The terms of each result, by a description in words.  A term is a function of ``(t, y, p)``;
        y has the components of the state by name, as arrays, p the parameters by name.
    solution : callable
        The function as a student writes it.
    ranges : dict of str to (float, float), optional
        The least and the largest value of a component or parameter; by default, a component has
        either sign.
    project : callable, optional
        ``project(y, p)`` moves states to states, {name: ndarray}, that satisfy the constraints.
        The equations are compared only at such states.
    free_zero : sequence of str, optional
        Names of results that are defined up to a constant, such as an energy.
    follows : dict of str to dict of str to callable, optional
        Terms that follow from other results, such as accelerations from a reaction, as functions of
        ``(t, y, p, a)``; a has the results of the student by name.  A wrong reaction is then named
        once, and not again in each acceleration.
    """

    name: str
    question: str
    state: Mapping[str, str]
    parameters: Mapping[str, str]
    answer: Mapping[str, str]
    terms: Mapping[str, Mapping[str, Callable]]
    solution: Callable
    ranges: Mapping[str, tuple[float, float]] = {}
    project: Callable | None = None
    free_zero: Sequence[str] = ()
    follows: Mapping[str, Mapping[str, Callable]] = {}

    @property
    def signature(self):
        """The first line of the student's function."""
        return f"def {self.name}({', '.join(['t', 'y', *self.parameters])}):"

    def samples(self, seed=1):
        """Random times, states and parameters by name, each of shape (STATES,)."""
        rng = np.random.default_rng(seed)
        t = rng.uniform(0.0, 5.0, STATES)
        y = {}
        for name in self.state:
            if name in self.ranges:
                y[name] = rng.uniform(*self.ranges[name], STATES)
            else:
                y[name] = rng.uniform(0.2, 1.5, STATES) * rng.choice([-1.0, 1.0], STATES)
        p = {
            name: rng.uniform(*self.ranges.get(name, POSITIVE), STATES) for name in self.parameters
        }
        return t, self.allowed(y, p), p

    def allowed(self, y, p):
        """States that satisfy the constraints, from `project`."""
        return y if self.project is None else self.project(Names(y), Names(p))

    def values(self, t, y, p):
        """The terms of each answer, {answer: {term: ndarray of shape (STATES,)}}.

        For an answer of `free_zero`, the values are the changes from one state to the next.
        """
        found = self.at(t, y, p)
        if self.free_zero:
            before = self.at(*self.elsewhere(t, y, p))
            for name in self.free_zero:
                found[name] = {key: one - before[name][key] for key, one in found[name].items()}
        return found

    def following(self, name, samples, answers):
        """The terms of an answer, {term: ndarray}, that follow from a student's other answers."""
        t, y, p = samples
        others = self.follows.get(name)
        if others is None:
            return None
        terms = self.at(t, y, p)[name]
        found = {k: evaluated(f, k, name, t, y, p, answers) for k, f in others.items()}
        return {**terms, **found}

    def elsewhere(self, t, y, p):
        """Other times and states with the same parameters."""
        return np.roll(t, 1), self.allowed({k: np.roll(one, 1) for k, one in y.items()}, p), p

    def at(self, t, y, p):
        """As `values`, the values themselves of an answer of `free_zero`."""
        return {
            name: {about: evaluated(term, about, name, t, y, p) for about, term in terms.items()}
            for name, terms in self.terms.items()
        }


def evaluated(term, about, name, t, *values):
    """A term at all states, shape (STATES,); a term for numbers, as with `math`, one by one."""
    try:
        try:
            found = term(t, *map(Names, values))
        except (TypeError, ValueError):
            rows = [[{k: v[i] for k, v in of.items()} for of in values] for i in range(len(t))]
            found = [term(at, *map(Names, row)) for at, row in zip(t, rows, strict=True)]
        found = np.broadcast_to(found, t.shape).astype(float)
    except Exception as error:
        said = f"The term of {about} in `{name}` raises {type(error).__name__}"
        raise ValueError(f"{said}: {str(error).rstrip('.')}") from error
    if not np.isfinite(found).all():
        raise ValueError(f"The term of {about} in `{name}` is no finite number everywhere")
    return found


class Names:
    """Arrays by name, as attributes: ``y.theta``."""

    def __init__(self, arrays):
        self.__dict__.update(arrays)

    def __getattr__(self, name) -> Any:
        raise AttributeError(f"The exercise has no `{name}`.")
