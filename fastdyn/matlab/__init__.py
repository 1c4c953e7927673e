"""MATLAB's ode45 and its other solvers with MATLAB's calls, names and defaults."""

from .delays import dde23, ddesd
from .ode_events import EventDefinition, odeEvent
from .ode_object import InitialValueProblem, ODEResults, ode
from .options import odeget, odeset
from .others import BoundarySolution, bvp4c, bvp5c, bvpinit, ode15i, odeplot
from .solution import Solution, deval
from .solvers import ode15s, ode23, ode23s, ode23t, ode23tb, ode45, ode78, ode89, ode113, odextend

__all__ = [
    "BoundarySolution", "EventDefinition", "InitialValueProblem", "ODEResults", "Solution", "bvp4c",
    "bvp5c", "bvpinit", "dde23", "ddesd", "deval", "ode", "ode15i", "ode15s", "ode23", "ode23s",
    "ode23t", "ode23tb", "ode45", "ode78", "ode89", "ode113", "odeEvent", "odeget", "odeplot",
    "odeset", "odextend",
]  # fmt: skip
