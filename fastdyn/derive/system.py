"""The `System` that a derivation makes."""

import dataclasses
from typing import Any, ClassVar

import numpy as np
import sympy as sp

from fastdyn.systems.base import (
    State,
    System,
    constraint,
    event,
    initial,
    invariant,
    parameter,
    quantity,
)
from fastdyn.systems.base.declare import of_instance
from fastdyn.systems.base.driver import driver_of

from .algebra import shortened
from .checks.consistency import kept, singular
from .checks.runs import refuse_coincidence, refuse_impossible_bodies, warn_of_pull
from .writing import Writer

KEPT = 1e-9  # largest rate of an invariant, relative to the largest term of the rate


class DerivedSystem(System):
    """
    A system whose functions were written by a `Derivation`.

    Attributes
    ----------
    derivation : Derivation
        The derivation of the equations; ``derivation.explain()`` prints its steps.
    """

    derivation: ClassVar[Any]
    lengths: ClassVar[Any]

    def __post_init__(self):
        super().__post_init__()
        for one in self.derivation.model.drivers:
            about = (
                f"`{one.name}` of the {self.name} must be a function of (t, w), or of t, that "
                f"returns {', '.join(one.gives)}"
            )
            object.__setattr__(self, one.name, driver_of(getattr(self, one.name), about))
        numbers = self.derivation.model.numbers
        values = {one.symbol: sp.Float(getattr(self, str(one.symbol))) for one in numbers}
        refuse_impossible_bodies(self.derivation, values)

    @of_instance
    def solve(
        self, t_span: Any = None, y0: Any = None, method: Any = "RK45", project=None, **options: Any
    ):
        """As `System.solve`; refuses springs without direction, and warns of contacts that pull."""
        self.refuse_coincidence(t_span, y0)
        result = super().solve(t_span, y0, method, project, **options)

        def values(names, points):
            t = result.t[points]
            y = np.asarray(result.y)[:, points]
            return {name: self.along(self.quantities[name], t, y) for name in names}

        warn_of_pull(result, values)
        return result

    def refuse_coincidence(self, t_span, y0):
        """Refuse a start at which a spring has no direction."""
        if self.lengths is not None:
            w = self.initial_state() if y0 is None else y0
            refuse_coincidence(self, 0.0 if t_span is None else t_span[0], w)

    def initial_state(self):
        """State at t = 0, on the constraints; ValueError if given components violate them."""
        model = self.derivation.model
        numbers = [getattr(self, str(one.symbol)) for one in model.numbers]
        drivers = [getattr(self, one.name) for one in model.drivers]
        return tuple(self.derivation.start.state(numbers, drivers))

    def settling(self):
        """What `initial_state` computes, as functions: see `Start.parts`."""
        drivers = [getattr(self, one.name) for one in self.derivation.model.drivers]
        return self.derivation.start.parts(drivers)

    def mass_matrix(self):
        """The Hessian of the kinetic energy by the rates of the coordinates."""
        found = self.derivation
        masses = shortened(sp.hessian(sp.expand(found.kinetic), found.motion.v))
        return Writer(found).numbers("mass", list(masses))

    def scene(self, t, w):
        """Bodies, joints, springs and surfaces of the model in one state."""
        return self.stage([t], np.reshape(np.asarray(w, float), (-1, 1)))(t, w)

    def stage(self, t, y):
        """As `System.stage`; a system that travels far is drawn larger."""
        from .picture.scenes import picture

        return picture(self).stage(t, y)

    def figure(self, results, **options):
        """The system with the paths of its bodies, beside the components of the state over time."""
        from .picture.figure import figure

        return figure(results, **options)


def system_of(derivation, kind=DerivedSystem):
    """The class of the derived system, a subclass of `kind`."""
    model = derivation.model
    writer = Writer(derivation)
    space: dict[str, Any] = {
        "__doc__": _described(derivation),
        "__module__": __name__,
        "__annotations__": {},
        "derivation": derivation,
        "name": model.name,
        "title": model.title,
        "source": model.source or "derived",
        "t_end": model.t_end,
        "states": _states(model),
    }
    space["rhs"] = staticmethod(writer.rhs())
    lengths = [derivation.plain(one) for one in model.lengths]
    space["lengths"] = staticmethod(writer.numbers("lengths", lengths)) if lengths else None
    for one in model.numbers:
        declare = initial if one.initial else parameter
        name = str(one.symbol)
        space[name] = declare(one.default, one.unit, one.meaning, positive=one.positive)
        space["__annotations__"][name] = float
    for one in model.drivers:
        space[one.name] = one.default
        space["__annotations__"][one.name] = Any
    space |= functions_of(derivation, writer)
    if derivation.held:
        space["project"] = staticmethod(writer.project(metric(derivation)))
    return dataclasses.dataclass(frozen=True)(type(_class_name(model), (kind,), space))


def _states(model):
    found = model.coordinate_list
    places = [State(one.name, one.unit, f"coordinate {one.name}") for one in found]
    speeds = [State(one.rate, f"{one.unit or 1}/s", f"rate of {one.name}") for one in found]
    return (*places, *speeds)


def functions_of(derivation, writer):
    """Energy, reactions, residuals of the constraints, and functions of the user."""
    model = derivation.model
    found = {}

    def add(kind, name, expression, unit, label, **options):
        written = writer.number(name, expression)
        written.__doc__ = f"{label}: {derivation.formula.text(expression)}"
        about = (unit, label) if kind is not event else ()
        found[name] = kind(*about, **options)(written)

    energy = shortened(derivation.kinetic + derivation.potential)
    constant = kept(derivation, energy) < KEPT
    add(invariant if constant else quantity, "energy", energy, "J", "energy E")
    for symbol, unit in derivation.reaction_units():
        add(quantity, str(symbol), symbol, unit, f"reaction {symbol}")
    for one in model.contacts:
        friction, slip, _ = one.names
        if one.name not in derivation.at_rest:
            add(quantity, friction, derivation.plain(one.size(False)), "N", friction)
        add(quantity, slip, derivation.plain(one.slip), "m/s", slip)
    for one in derivation.held:
        if one.name in found:  # the slip of a contact that rests
            continue
        rate = f"{one.unit}/s" if one.position is not None else one.unit
        if one.position is not None:
            add(constraint, one.name, one.position, one.unit, f"constraint {one.name}")
        name = one.name if one.position is None else f"{one.name}_rate"
        add(constraint, name, one.velocity, rate, f"rate of {one.name}")
    for one in model.functions:
        expression = derivation.plain(one.expression)
        if one.kind == "invariant" and not (off := kept(derivation, expression)) < KEPT:
            raise ValueError(
                f"`{one.name}` of {model.name} is no invariant: its terms change, and the sum of "
                f"their rates is {off:.1g} of the largest."
            )
        kind = {"quantity": quantity, "invariant": invariant, "event": event}[one.kind]
        add(kind, one.name, expression, one.unit, one.label or one.name, **one.event)
    return found


def metric(derivation):
    """The masses that weigh a projection; if they are not regular, all components weigh 1."""
    v = derivation.motion.v
    masses = shortened(sp.hessian(sp.expand(derivation.kinetic), v))
    rows = [one.row for one in derivation.held if one.position is not None]
    groups = [rows] if rows else []
    groups.append([one.row for one in derivation.held])
    for group in groups:
        A = sp.Matrix.vstack(*group)
        whole = sp.Matrix(sp.BlockMatrix([[masses, -A.T], [A, sp.zeros(A.rows)]]))
        if singular(derivation.points, whole):
            return sp.eye(len(v))
    return masses


def _class_name(model):
    return "".join(word.capitalize() for word in model.name.split("_"))


def _described(derivation):
    """A docstring: the equations, solved or not."""
    model = derivation.model
    formula = derivation.formula
    lines = [f"{model.title}.", "", "Equations of motion::", ""]
    lines += [f"    {formula.text(row)} = 0" for row in derivation.residuals()]
    names = ", ".join([one.name for one in model.coordinate_list])
    rates = ", ".join([one.rate for one in model.coordinate_list])
    return "\n".join([*lines, "", f"State ``[{names}, {rates}]``."])
