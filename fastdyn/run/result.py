"""OdeResult, the result of a solve."""

import functools
from operator import itemgetter
from typing import Any

import numpy as np


class Missing(KeyError, AttributeError):
    """Raised for a missing field of a result, read as a key or as an attribute."""


class OdeResult(dict):
    """A dict with attribute access: SciPy's fields and a few more.

    Attributes
    ----------
    t : ndarray, shape (n_points,)
        Times, in the unit of `t_span`.
    y : ndarray, shape (n, n_points)
        States at these times.
    sol : OdeSolution or None
        The continuous solution, with ``dense_output=True``.
    t_events, y_events : list of ndarray or None
        For each event, its times (k,) and the states there (k, n).
    nfev, njev, nlu : int
        Numbers of evaluations of `fun`, of Jacobians, of factorisations.
    status : int
        0: the end was reached; 1: a terminal event; -1: failure; -2: interrupted.
    message : str
        The reason of the end, in a sentence.
    success : bool
        True if `status` is 0 or 1.
    n_accepted, n_rejected : int
        Numbers of steps (compiled methods only).
    """

    t: np.ndarray
    y: np.ndarray
    sol: Any
    t_events: Any
    y_events: Any
    nfev: int
    njev: int
    nlu: int
    status: int
    message: str
    success: bool
    n_accepted: int
    n_rejected: int

    _unmade: Any = None  # (functions that make the parts, their data) until all parts are made

    @classmethod
    def of_parts(cls, parts, given):
        """A result whose parts, ``parts[name](given)``, are made at their first use."""
        result = cls()
        result.__dict__["_unmade"] = parts, given
        return result

    def __missing__(self, name):
        if self._unmade is None:
            raise Missing(name)
        parts, given = self._unmade
        value = self[name] = parts[name](given)
        return value

    def _make(self):
        """Make all parts, in their order."""
        if self._unmade is None:
            return
        parts, given = self._unmade
        made = dict(dict.items(self))
        whole = {name: made.pop(name) if name in made else parts[name](given) for name in parts}
        dict.clear(self)
        self.update(whole, **made)
        self.__dict__.pop("_unmade", None)

    def __getattr__(self, name) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name, value):
        self[name] = value

    def __delattr__(self, name):
        del self[name]

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __repr__(self):
        width = max(map(len, self), default=0)
        lines = []
        for name, value in self.items():
            text = repr(value).replace("\n", "\n" + " " * (width + 2))
            lines.append(f"{name:>{width}}: {text}")
        return "\n".join(lines)

    def plot(self, **options) -> Any:
        """Draw the components over time; the result of a system draws the figure of the system.

        Parameters
        ----------
        **options
            Options of `fastdyn.plot.solution.plot`, or of the figure of the system.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.solution import plot

        return plot(self, **options)


def _on_whole(name):
    """A method of dict that makes all parts first."""
    method = getattr(dict, name)

    @functools.wraps(method)
    def on_whole(self, *args):
        self._make()
        return method(self, *args)

    return on_whole


for _name in (
    "keys", "values", "items", "get", "pop", "popitem", "setdefault", "copy", "clear",
    "__iter__", "__reversed__", "__len__", "__contains__", "__delitem__", "__eq__", "__ne__",
    "__or__", "__ror__", "__ior__", "__reduce_ex__",
):  # fmt: skip
    setattr(OdeResult, _name, _on_whole(_name))

for _name in tuple(OdeResult.__annotations__):  # as properties in C: a seventh of the time
    if not _name.startswith("_"):
        setattr(OdeResult, _name, property(itemgetter(_name)))
