"""MATLAB's ode45 and its other solvers with MATLAB's calls, names and defaults."""

from .delays import dde23, ddesd
from .options import odeget, odeset
from .others import BoundarySolution, bvp4c, bvp5c, bvpinit, ode15i, odeplot
from .solution import Solution, deval
from .solvers import ode15s, ode23, ode23s, ode23t, ode23tb, ode45, ode78, ode89, ode113, odextend

__all__ = [
    "BoundarySolution", "Solution", "bvp4c", "bvp5c", "bvpinit", "dde23", "ddesd", "deval",
    "ode15i", "ode15s", "ode23", "ode23s", "ode23t", "ode23tb", "ode45", "ode78", "ode89",
    "ode113", "odeget", "odeplot", "odeset", "odextend",
]  # fmt: skip
