"""fastdyn: equations of motion, integrated at compiled speed behind SciPy's solve_ivp."""

from fastdyn.compile.diagnostics import CompileWarning
from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.kernels.algebra.linear import SingularMatrixError, solve_linear
from fastdyn.run.dense_output import OdeSolution
from fastdyn.run.result import OdeResult
from fastdyn.solve.ivp import solve_ivp, solve_second_order, solve_separable

__version__ = "0.1.0"


STUDIES = {
    "Fold": "ensemble.reductions",
    "Shared": "ensemble.members",
    "compare_drift": "drift.compare",
    "energy_drift": "drift.energy",
    "prepare": "solve.prepared",
    "solve_ensemble": "ensemble.solve",
    "time_transformed": "solve.time_transform",
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
