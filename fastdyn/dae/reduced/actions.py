"""Functions of `on_event` on the reduced state: behind them, all constraints hold again."""

import numpy as np

from fastdyn.compile.mode import JUMP
from fastdyn.compile.python_callback import derivative

from ..structure.start import Unsolved, consistent
from .trajectory import components, orders, places


class Action:
    """A function of the reduced state for the user's function of y.

    Attributes
    ----------
    bad : str or None
        Why the run ends here: the user's function returned nan or inf.
    """

    bad = None

    def __init__(self, system, act, held):
        self._system = system
        self._act = act
        self._held = held

    def __call__(self, t, x, p, *args):
        system = self._system
        given = self._system.given
        y = components(system, [t], x[:, None], project=True)[:, 0]
        new = derivative(self._act(t, y, *args), given.n, JUMP)
        bad = np.flatnonzero(~np.isfinite(new))
        if bad.size:
            self.bad = f"`on_event` returned nan or inf at t = {t:.10g} (component {bad[0]})."
            return np.full(len(x), np.nan)
        z = orders(system, x)
        for k, value in enumerate(new):
            column, order = given.place(k)
            z[order * given.n + column] = value
        try:
            return consistent(system, t, z, self._held)[places(system)]
        except Unsolved as reason:
            raise ValueError(
                f"the state that `on_event` returned at t = {t:.10g} is none of the equations: "
                f"{reason}"
            ) from None
