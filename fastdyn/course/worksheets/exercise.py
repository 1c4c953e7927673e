"""The record of an exercise."""

from collections.abc import Callable
from typing import NamedTuple


class Answer(NamedTuple):
    """The outcome in a sentence, and whether it is as the exercise expects."""

    text: str
    holds: bool


class Exercise(NamedTuple):
    """A question on a system.

    Parameters
    ----------
    question : str
    command : str
        What to try in the shell, or "" for what takes Python.
    answer : callable
        Computes an `Answer`.
    """

    question: str
    command: str
    answer: Callable[[], Answer]


def close(computed, expected, share=1e-6):
    """Whether a number is the expected one to within a share of it."""
    return bool(abs(computed - expected) <= share * abs(expected))
