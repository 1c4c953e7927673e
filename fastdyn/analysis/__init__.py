"""Functions of a course on dynamics, in a line each: equilibria, portraits, orbits, exponents.

Every function takes a plain function ``fun(t, y, *args)`` or a system of `fastdyn.systems` or
`fastdyn.derive`, and returns a result that can be printed and has ``plot()``.
"""

from .basins import Basin, basin
from .branch import Branch, continuation
from .equations import NotConvergedError
from .exponents import Exponents, lyapunov
from .orbit import PeriodicOrbit, periodic_orbit
from .portrait import Portrait, phase_portrait
from .response import Response, frequency_response
from .rest.delays import DelayRoots, characteristic_roots
from .rest.equilibria import Equilibria, equilibria
from .rest.linear import Linearisation, Mode, linearise
from .section import Section, poincare

__all__ = [
    "Basin", "Branch", "DelayRoots", "Equilibria", "Exponents", "Linearisation", "Mode",
    "NotConvergedError", "PeriodicOrbit", "Portrait", "Response", "Section", "basin",
    "characteristic_roots", "continuation", "equilibria", "frequency_response", "linearise",
    "lyapunov", "periodic_orbit", "phase_portrait", "poincare",
]  # fmt: skip
