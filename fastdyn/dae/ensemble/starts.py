"""Consistent starts of many trajectories, each by the rule of a single solve.

A trajectory without a consistent start fails alone, with the sentence of the single solve.
"""

import numpy as np

from fastdyn.compile.sentences import GaveUp, Uncompilable


def starts_of(guesses, n_numbers, consistent, decisive=()):
    """(Starts, one row each; the sentences of the trajectories without one, by their numbers).

    ``consistent(i)`` has the `n_numbers` numbers of the start of trajectory i, or raises; rows of
    trajectories that fail are nan.  There is one row if all trajectories begin alike.

    Raises
    ------
    Exception
        That of the first trajectory if none has a start; and one of the classes `decisive` from a
        trajectory before which none has.
    """
    starts, errors, left = beginning(guesses, n_numbers)
    found = False
    for i in left.tolist():
        try:
            starts[i] = consistent(i)
            found = True
        except (Uncompilable, GaveUp):
            raise
        except Exception as error:  # of this trajectory alone
            if not found and isinstance(error, decisive):
                raise
            errors[i] = error
    return starts, sentences(errors, left)


def beginning(guesses, n_numbers):
    """(Rows of nan for the starts, an error for each guess that is not finite, the others)."""
    alike = len(guesses.y0) == 1 and not guesses.varying
    starts = np.full((1 if alike else guesses.count, n_numbers), np.nan)
    finite = np.broadcast_to(guesses.finite, len(starts))
    errors: dict[int, Exception] = {
        i: ValueError(_not_finite(guesses.state(i))) for i in np.flatnonzero(~finite).tolist()
    }
    return starts, errors, np.flatnonzero(finite)


def sentences(errors, left):
    """The sentences of errors; raises the first if all the trajectories `left` have one."""
    if all(i in errors for i in left.tolist()):
        raise errors[int(left[0])]
    return {i: _sentence(error) for i, error in errors.items()}


def _not_finite(guess):
    place = int(np.argmin(np.isfinite(guess)))
    n = len(guess) // 2
    name = "y0" if place < n else "yp0"
    return f"component {place % n} of `{name}` is not finite"


def _sentence(error):
    said = f"{error}".rstrip(".")
    return said if isinstance(error, ValueError) else f"`F` raised {type(error).__name__}: {said}"
