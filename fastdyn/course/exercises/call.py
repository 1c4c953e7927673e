"""Calls a student's function with the arguments of an exercise, and reads the result."""

import collections.abc
import inspect
import warnings

import numpy as np

from fastdyn.words.raised import explain


class Refused(Exception):
    """A sentence about a function that cannot be compared."""


class ExerciseCall:
    """
    A function that takes the parameters of an exercise in the exercise's order.

    Parameters
    ----------
    exercise : Exercise
    function : callable
        Parameters are matched by name; parameters with other names, in the order of the exercise.

    Attributes
    ----------
    notes : list of str
        Deviations from the exercise that are no errors.

    Raises
    ------
    Refused
        If the number of arguments is not that of the exercise.
    """

    def __init__(self, exercise, function):
        self.exercise = exercise
        self.function = function
        self.notes = []
        self.places = list(range(len(exercise.parameters)))
        names = _arguments(function)
        if names is not None:
            self._place(names)

    def _place(self, names):
        """Match the arguments with the parameters of the exercise."""
        asked = list(self.exercise.parameters)
        line = self.exercise.signature
        if len(names) > 1 and names[1] == "t":
            raise Refused(f"It takes `{names[0]}` before t; asked for is `{line}`")
        if len(names) != 2 + len(asked):
            raise Refused(f"It takes ({', '.join(names)}); asked for is `{line}`")
        given = names[2:]
        rest = [name for name in asked if name not in given]
        found = [name if name in asked else rest.pop(0) for name in given]
        self.places = [asked.index(name) for name in found]
        if others := [f"{a} as {b}" for a, b in zip(given, found, strict=True) if a not in asked]:
            self.notes.append(f"Its parameters are taken in order: {', '.join(others)}.")
        elif found != asked:
            self.notes.append(
                f"Its parameters are taken by name: {', '.join(given)}; asked for are "
                f"{', '.join(asked)}."
            )

    def values(self, t, y, p):
        """
        The results of the function at times, states and parameters, {answer: ndarray}.

        Raises
        ------
        Refused
            With a sentence about an exception, or about the result.
        """
        found = self._values(t, y, p)
        if self.exercise.free_zero:
            before = self._values(*self.exercise.elsewhere(t, y, p))
            found |= {name: found[name] - before[name] for name in self.exercise.free_zero}
        return found

    def _values(self, t, y, p):
        rows = []
        names = list(self.exercise.answer)
        for n in range(len(t)):
            state = np.array([one[n] for one in y.values()])
            given = [float(one[n]) for one in p.values()]
            rows.append(self._row(float(t[n]), state, [given[k] for k in self.places], names))
        return dict(zip(names, np.array(rows).T, strict=True))

    def _row(self, t, state, given, names):
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")  # a sentence reports values that are not finite
                value = self.function(t, state, *given)
        except KeyboardInterrupt:
            raise
        except SystemExit:
            raise Refused("It ends Python, by exit, quit or sys.exit.") from None
        except BaseException as error:
            form = self.exercise.signature[len("def ") : -1]
            explain(error, "It", form, t, state, self.function, given)
            notes = getattr(error, "__notes__", ())
            said = " ".join([f"It raises {type(error).__name__}: {error}.", *notes])
            raise Refused(said) from None
        return _numbers(value, names)


def _arguments(function):
    """Names of the arguments that a call must give; None if any number may be given."""
    try:
        asked = inspect.signature(getattr(function, "py_func", function)).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(one.kind is one.VAR_POSITIONAL for one in asked):
        return None
    by_place = [
        one for one in asked if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)
    ]
    return [one.name for one in by_place if one.default is one.empty]


def _numbers(value, names):
    """A result as one float for each name; the result may be a list, a row or a column."""
    wanted = f"{_of(len(names))} asked for: {', '.join(names)}."
    if value is None:
        raise Refused(f"It returns None: is a `return` missing? {wanted}")
    unordered = isinstance(value, str | bytes | collections.abc.Mapping | collections.abc.Set)
    try:
        plain = np.array(value)
        if unordered or np.iscomplexobj(plain):
            raise TypeError
        row = np.array(plain, float)
    except (TypeError, ValueError):
        kind = type(value).__name__
        article = "an" if kind[0] in "aeiou" else "a"
        raise Refused(f"It returns {article} {kind} that is no list of numbers; {wanted}") from None
    if row.size != len(names):
        raise Refused(f"It returns {row.size} number{'s' * (row.size != 1)}; {wanted}")
    if max(row.shape, default=1) != row.size:
        shape = " by ".join(map(str, row.shape))
        raise Refused(f"It returns a matrix of {shape}; {wanted}")
    return row.reshape(-1)


def _of(count):
    return f"{count} {'is' if count == 1 else 'are'}"
