"""Solves F(t, y, y') = 0 of any index by index reduction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastdyn.problem.validate import method_named

from ..problem import held_components
from ..structure.reduction import Reduction
from ..structure.start import consistent, guess
from .compare import check_with_function
from .run import run
from .sensitivities import ReducedTangent

if TYPE_CHECKING:
    from fastdyn.run.result import OdeResult


def solve_reduced(given, method) -> OdeResult:
    """The OdeResult of a problem.DaeArguments of any index, by index reduction.

    The derivatives of all states are computed from the equations and their derivatives, by
    compiled code, and integrated by a method of `solve_ivp`. After each step the state moves to the
    nearest one that satisfies all constraints, hidden ones included.

    The result has y of all components; `yp`, their derivatives, nan where the equations have none;
    `index`; `differentiated`, how often each equation was differentiated; `states`, a list of
    (time, components that are states from there on), where n l + j stands for derivative l of
    component j.

    Raises
    ------
    ValueError, TypeError
        For a function that cannot be traced, for a singular structure, for a start that is not
        consistent, and for wrong options.
    """
    reduction = Reduction(given)
    check_method(method, reduction)
    held = checked_held(held_components(given), reduction)
    z = guess(reduction.system, given.y0, given.yp0)
    z = consistent(reduction.system, given.t0, z, held)
    tangent = None
    if given.directions is not None:
        for name in ("on_event", "at", "every"):
            if given.options.get(name) is not None:
                raise ValueError(
                    f"`sensitivity` and `{name}` do not go together at an index above 1, nor with "
                    "another method than BDF."
                )
        tangent = ReducedTangent(reduction, given, held)
    found = run(reduction, given, z, method, held, tangent)
    jumps = given.options.get("breakpoints")
    check_with_function(given.F, given.args, found, () if jumps is None else jumps)
    return found


def check_method(method, reduction):
    """Raise ValueError for a method that does not solve the equations of a Reduction."""
    found = method_named(method)
    constrained = reduction.system.offsets.equations.any()
    if found is None or found.second_order or (constrained and not found.projects):
        raise ValueError(
            f"`method={method!r}` cannot return a state to its constraints; take an adaptive "
            "explicit method (DOP853, Vern9, Taylor, ...), or Radau or Rodas5P for stiff equations."
        )


def checked_held(held, reduction):
    """The set of components that keep their values, or None; ValueError for algebraic ones."""
    if held is None:
        return None
    system = reduction.system
    d = system.offsets.components - system.extra
    free = {system.name(j, order) for j, order in system.states if order < d[j]}
    algebraic = sorted(held - free)
    if algebraic:
        raise ValueError(
            f"component {algebraic[0]} cannot be `given`: the equations determine it from the "
            "others at each time."
        )
    return held
