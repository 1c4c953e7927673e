"""Problems of many trajectories: one function with many initial states or parameters."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fastdyn.systems import building

from . import equations


class Many(NamedTuple):
    """A function with a row of initial states and one of parameters for each trajectory.

    Attributes
    ----------
    name : str
    terms : callable
        The equations over a namespace.
    t_end : float
        Where all end, which begin at 0.
    y0 : ndarray, shape (count, n)
    parameters : ndarray, shape (count, m)
    """

    name: str
    terms: Callable
    t_end: float
    y0: np.ndarray
    parameters: np.ndarray

    @property
    def fun(self):
        """``fun(t, y, *parameters)`` in plain Python."""
        return self.terms(math)

    def some(self, few):
        """Those of a slice alone."""
        return self._replace(y0=self.y0[few], parameters=self.parameters[few])


def satellites(count):
    """Satellites with many speeds."""
    y0 = np.zeros((count, 4))
    y0[:, 0], y0[:, 3] = 1.0, np.random.default_rng(0).uniform(0.8, 1.2, count)
    return Many("satellite", equations.satellite, 100.0, y0, np.ones((count, 1)))


def buildings(count):
    """Buildings over ground of many frequencies."""
    system = building()
    parameters = np.tile(system.args[:6], (count, 1))
    parameters[:, 2] = np.linspace(1.0, 30.0, count)
    y0 = np.tile(system.initial_state(), (count, 1))
    return Many("building", equations.building, 20.0, y0, parameters)


MANY = (satellites, buildings)
