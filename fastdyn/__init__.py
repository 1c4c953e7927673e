"""fastdyn: equations of motion, integrated at compiled speed behind SciPy's solve_ivp."""

__version__ = "0.1.0"  # first: modules below ask for it

import importlib
import os
from typing import TYPE_CHECKING

if not os.path.isdir(os.path.join(__path__[0], "kernels")):  # in the folder of a checkout, as ""
    __path__.append(os.path.dirname(os.path.abspath(__path__[0])))  # in which kernels/ lies

from fastdyn.compile.callables.diagnostics import CompileWarning
from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.kernels.algebra.linear import SingularMatrixError, solve_linear
from fastdyn.kernels.methods import METHODS
from fastdyn.problem.schedules import at, every
from fastdyn.run.dense_output import OdeSolution
from fastdyn.run.result import OdeResult
from fastdyn.run.stiffness import StiffnessWarning
from fastdyn.solve.ivp import solve_ivp
from fastdyn.solve.second_order import solve_second_order
from fastdyn.solve.separable import solve_separable

if TYPE_CHECKING:
    from fastdyn import analysis, systems
    from fastdyn.dae.solve import solve_dae
    from fastdyn.dae.structure.reduction import reduce_index
    from fastdyn.drift.compare import compare_drift
    from fastdyn.drift.energy import energy_drift
    from fastdyn.ensemble.reductions import Fold
    from fastdyn.ensemble.solve import solve_ensemble
    from fastdyn.ensemble.trajectories import Trajectories
    from fastdyn.problem.members import Shared
    from fastdyn.solve.phases import Phase, solve_phases
    from fastdyn.solve.prepare import prepare
    from fastdyn.solve.stepper import Stepper
    from fastdyn.solve.time_transform import time_transformed
    from fastdyn.systems import System

_LAZY = {  # name: module, imported when the name is first asked for
    "Fold": "fastdyn.ensemble.reductions",
    "Phase": "fastdyn.solve.phases",
    "Shared": "fastdyn.problem.members",
    "Stepper": "fastdyn.solve.stepper",
    "System": "fastdyn.systems",
    "Trajectories": "fastdyn.ensemble.trajectories",
    "compare_drift": "fastdyn.drift.compare",
    "energy_drift": "fastdyn.drift.energy",
    "prepare": "fastdyn.solve.prepare",
    "reduce_index": "fastdyn.dae.structure.reduction",
    "solve_dae": "fastdyn.dae.solve",
    "solve_ensemble": "fastdyn.ensemble.solve",
    "solve_phases": "fastdyn.solve.phases",
    "time_transformed": "fastdyn.solve.time_transform",
}

__all__ = [
    "METHODS", "CompileWarning", "Fold", "OdeResult", "OdeSolution", "Phase", "Shared",
    "SingularMatrixError", "Stepper", "StiffnessWarning", "System", "Trajectories", "__version__",
    "analysis", "at", "compare_drift", "constrained", "energy_drift", "every", "prepare",
    "reduce_index",
    "solve_dae", "solve_ensemble", "solve_ivp", "solve_linear", "solve_phases",
    "solve_second_order", "solve_separable", "systems", "time_transformed",
]  # fmt: skip


def __getattr__(name):
    if name in ("analysis", "systems"):
        return importlib.import_module(f"fastdyn.{name}")
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'fastdyn' has no attribute {name!r}")


def __dir__():
    return sorted(__all__)
