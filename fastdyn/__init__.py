"""fastdyn: equations of motion, integrated at compiled speed behind SciPy's solve_ivp."""

from .adapt import CompileWarning
from .result import OdeResult, OdeSolution
from .solve import solve_ivp, solve_second_order

__version__ = "0.1.0"
__all__ = ["CompileWarning", "OdeResult", "OdeSolution", "solve_ivp", "solve_second_order"]
