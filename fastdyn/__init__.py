"""fastdyn: equations of motion, integrated at compiled speed behind SciPy's solve_ivp."""

__version__ = "0.1.0"  # first: modules below ask for it

import importlib
import os
import warnings
from typing import TYPE_CHECKING

if not os.path.isdir(os.path.join(__path__[0], "kernels")):  # in the folder of a checkout, as ""
    __path__.append(os.path.dirname(os.path.abspath(__path__[0])))  # in which kernels/ lies

from fastdyn.compile.sentences import CompileWarning
from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.kernels.algebra.linear import SingularMatrixError, solve_linear
from fastdyn.kernels.methods import METHODS
from fastdyn.problem.schedules import at, every
from fastdyn.run.dense_output import OdeSolution
from fastdyn.run.functions.switching import SwitchingWarning
from fastdyn.run.result import OdeResult
from fastdyn.run.stiffness import StiffnessWarning
from fastdyn.solve.ivp import solve_ivp

if TYPE_CHECKING:
    from fastdyn import analysis, systems
    from fastdyn.dae.ensemble.solve import solve_dae_ensemble
    from fastdyn.dae.solve import solve_dae
    from fastdyn.delays import solve_dde, solve_dde_ensemble
    from fastdyn.drift.energy import energy_drift
    from fastdyn.ensemble.solve import solve_ensemble
    from fastdyn.fitting import Fit, Free, Record, fit
    from fastdyn.integrate import odeint
    from fastdyn.integrate.classes import complex_ode, ode
    from fastdyn.noise import solve_langevin, solve_sde
    from fastdyn.solve.boundary.solve import solve_bvp
    from fastdyn.solve.phases import Phase, solve_phases
    from fastdyn.solve.prepare import prepare
    from fastdyn.solve.stepper import Stepper

_LAZY = {  # name: module, imported when the name is first asked for
    "Fit": "fastdyn.fitting",
    "Free": "fastdyn.fitting",
    "Phase": "fastdyn.solve.phases",
    "Record": "fastdyn.fitting",
    "Stepper": "fastdyn.solve.stepper",
    "energy_drift": "fastdyn.drift.energy",
    "fit": "fastdyn.fitting",
    "complex_ode": "fastdyn.integrate",
    "ode": "fastdyn.integrate",
    "odeint": "fastdyn.integrate",
    "prepare": "fastdyn.solve.prepare",
    "solve_bvp": "fastdyn.solve.boundary.solve",
    "solve_dae": "fastdyn.dae.solve",
    "solve_dae_ensemble": "fastdyn.dae.ensemble.solve",
    "solve_dde": "fastdyn.delays",
    "solve_dde_ensemble": "fastdyn.delays",
    "solve_ensemble": "fastdyn.ensemble.solve",
    "solve_langevin": "fastdyn.noise",
    "solve_phases": "fastdyn.solve.phases",
    "solve_sde": "fastdyn.noise",
}
_FOLDERS = (  # with public names of their own, imported when they are first asked for
    "analysis", "dae", "delays", "derive", "drift", "ensemble", "integrate", "matlab", "noise",
    "planets", "systems",
)  # fmt: skip
_MOVED = {  # deprecated since 0.1.0: name: the folder that has the name now
    "Fold": "ensemble",
    "Shared": "ensemble",
    "System": "systems",
    "Trajectories": "ensemble",
    "compare_drift": "drift",
    "reduce_index": "dae",
    "solve_second_order": "solve",
    "solve_separable": "solve",
    "time_transformed": "solve",
}

__all__ = [
    "METHODS", "CompileWarning", "Fit", "Free", "OdeResult", "OdeSolution", "Phase", "Record",
    "SingularMatrixError", "Stepper", "StiffnessWarning", "SwitchingWarning", "__version__",
    "analysis", "at", "complex_ode", "constrained", "energy_drift", "every", "fit", "ode", "odeint",
    "prepare",
    "solve_bvp", "solve_dae", "solve_dae_ensemble", "solve_dde", "solve_dde_ensemble",
    "solve_ensemble", "solve_ivp", "solve_langevin", "solve_linear", "solve_phases", "solve_sde",
    "systems",
]  # fmt: skip


def __getattr__(name):
    if name in _FOLDERS:
        return importlib.import_module(f"fastdyn.{name}")
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name]), name)
    if name in _MOVED:
        folder = f"fastdyn.{_MOVED[name]}"
        warnings.warn(
            f"fastdyn.{name} is deprecated since 0.1.0: write `from {folder} import {name}`.",
            DeprecationWarning,
            stacklevel=2,
        )
        return getattr(importlib.import_module(folder), name)
    raise AttributeError(f"module 'fastdyn' has no attribute {name!r}{_meant(name)}")


def _meant(name):
    """A proposal for a name that is not here; none for those of Python's machinery."""
    from fastdyn.words.near import did_you_mean

    elsewhere = {"Ensemble": "solve_ensemble"}
    elsewhere |= dict.fromkeys(("ode45", "ode23", "ode15s", "odeset", "deval"), "matlab")
    near = elsewhere.get(name)
    said = f"did you mean `{near}`?" if near else name[0] != "_" and did_you_mean(name, __dir__())
    return f"; {said}" if said else ""


def __dir__():
    return sorted({*__all__, *_FOLDERS})
