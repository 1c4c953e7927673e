"""Functions of a driver, which may be of the time alone."""

import inspect


def driver_of(function, about):
    """
    A driver as a function of (t, w); a function of t alone is wrapped.

    Raises
    ------
    TypeError
        For an object that takes neither (t, w) nor t; `about` describes the result of a driver.
    """
    for arguments in ((0.0, ()), (0.0,)):
        try:
            inspect.signature(function).bind(*arguments)
        except (TypeError, ValueError):
            continue
        return function if len(arguments) == 2 else OfTime(function)
    raise TypeError(f"{about}; got {function!r}.")


class OfTime:
    """A driver that depends on the time alone."""

    def __init__(self, function):
        self.function = function
        self.__name__ = getattr(function, "__name__", "driver")

    def __call__(self, t, w):
        return self.function(t)

    def __eq__(self, other):
        return isinstance(other, OfTime) and self.function == other.function

    def __hash__(self):
        return hash(self.function)
