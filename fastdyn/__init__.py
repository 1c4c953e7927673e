"""fastdyn: equations of motion, integrated at compiled speed behind SciPy's solve_ivp."""

from .dense import OdeSolution
from .kernels.constrained import constrained
from .kernels.linear import SingularMatrixError, solve_linear
from .refusal import CompileWarning
from .result import OdeResult
from .solve import solve_ivp, solve_second_order, solve_separable

__version__ = "0.1.0"


STUDIES = {
    "Fold": "reductions",
    "Shared": "members",
    "compare_drift": "compare",
    "energy_drift": "drift",
    "prepare": "prepared",
    "solve_ensemble": "ensemble",
    "time_transformed": "transform",
}


def __getattr__(name):
    """Load the systems and the studies, and with them SciPy, when they are first asked for."""
    import importlib

    if name in STUDIES:
        return getattr(importlib.import_module(f"fastdyn.{STUDIES[name]}"), name)
    if name in ("systems", "System"):
        systems = importlib.import_module("fastdyn.systems")
        return systems if name == "systems" else systems.System
    raise AttributeError(f"module 'fastdyn' has no attribute {name!r}")


__all__ = [
    "CompileWarning", "OdeResult", "OdeSolution", "SingularMatrixError", "constrained",
    "solve_ivp", "solve_linear", "solve_second_order", "solve_separable",
]  # fmt: skip
