"""An exercise: its question, its names with units, and the terms of its reference."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

STATES = 60  # random ones, at which equations are compared


class Exercise(NamedTuple):
    """
    An exercise.

    Parameters
    ----------
    name : str
        Of the function that a student writes.
    question : str
    state : dict of str to str
        Names of the components of the state, and their units.
    parameters : dict of str to str
        Names of the arguments after the state, and their units; their values are positive.
    answer : dict of str to str
        Names of what the function returns, and their units.
    terms : dict of str to dict of str to callable
        For each name of the answer its terms, by what they are in words: functions of
        ``(t, y, p)`` with the state by name in y, arrays, and the parameters by name in p.
    solution : callable
        The function as a student writes it.
    """

    name: str
    question: str
    state: Mapping[str, str]
    parameters: Mapping[str, str]
    answer: Mapping[str, str]
    terms: Mapping[str, Mapping[str, Callable]]
    solution: Callable

    @property
    def signature(self):
        """The line with which the student begins."""
        return f"def {self.name}(t, y, {', '.join(self.parameters)}):"

    def samples(self):
        """Random times, states and parameters by name, each of shape (STATES,)."""
        rng = np.random.default_rng(1)
        t = rng.uniform(0.0, 5.0, STATES)
        y = {name: rng.uniform(0.2, 1.5, STATES) * rng.choice([-1.0, 1.0], STATES)
             for name in self.state}  # fmt: skip
        return t, y, {name: rng.uniform(0.5, 2.0, STATES) for name in self.parameters}

    def values(self, t, y, p):
        """The terms of each answer: {answer: {term: ndarray of shape (STATES,)}}."""
        return {
            name: {about: np.broadcast_to(term(t, Names(y), Names(p)), t.shape).astype(float)
                   for about, term in terms.items()}
            for name, terms in self.terms.items()
        }  # fmt: skip


class Names:
    """Arrays by name, as attributes: ``y.theta``."""

    def __init__(self, arrays):
        self.__dict__.update(arrays)

    def __getattr__(self, name) -> Any:
        raise AttributeError(f"The exercise has no `{name}`.")
