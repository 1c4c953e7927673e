"""SciPy's `scipy.integrate`, with the solvers of differential equations compiled.

`odeint`, `ode`, `complex_ode`, `solve_ivp`, `solve_bvp` and `OdeSolution` are fastdyn's; all other
names, as `quad` and `simpson`, are SciPy's own: ``from fastdyn import integrate`` takes the place
of ``from scipy import integrate``.
"""

from fastdyn.run.dense_output import OdeSolution
from fastdyn.solve.ivp import solve_ivp

from .odeint import odeint

_LAZY = {
    "complex_ode": "fastdyn.integrate.classes",
    "ode": "fastdyn.integrate.classes",
    "solve_bvp": "fastdyn.solve.boundary.solve",
}
__all__ = [  # pyright: ignore
    "OdeSolution", "complex_ode", "ode", "odeint", "solve_bvp", "solve_ivp",
]  # fmt: skip


def __getattr__(name):
    import importlib

    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name]), name)
    if name.startswith("__"):
        raise AttributeError(f"module 'fastdyn.integrate' has no attribute {name!r}")
    import scipy.integrate

    try:
        return getattr(scipy.integrate, name)
    except AttributeError:
        raise AttributeError(f"module 'fastdyn.integrate' has no attribute {name!r}") from None


def __dir__():
    import scipy.integrate

    return sorted({*__all__, *scipy.integrate.__all__})
