"""Equations of motion from a model: collected, checked, solved for the accelerations."""

import functools
from typing import Any, NamedTuple

import sympy as sp

from . import laws
from .algebra import linear, shortened, solved
from .bodies import Force
from .checks.consistency import Points, determined
from .checks.runs import refuse_impossible_bodies
from .checks.traps import warn_of_traps
from .code import printed
from .declarations import Constraint, Reaction
from .explain import Explanation
from .formulas import Formulas
from .kinematics import Motion
from .notation import now
from .start import Start

LIMIT = 250  # equations with at most so many operations are solved by formulas


class HeldConstraint(NamedTuple):
    """A constraint: its residual, the rate of the residual, and the row of A q'' = b."""

    name: str
    unit: str
    position: Any  # None for a constraint on velocities
    velocity: Any
    row: sp.Matrix
    b: Any


class Derivation:
    """
    The equations of motion of a model, and the steps of their derivation.

    Parameters
    ----------
    model : Model
    law : str
        "newton" or "lagrange".
    at_rest : set of str
        Names of the contacts with friction that rest; the others slip.

    Attributes
    ----------
    system : type
        The `fastdyn.systems.System`, to be called with parameters by name.
    unknowns : list of Symbol
        Accelerations, then reactions.
    K, r : Matrix
        The equations K u = r that determine the unknowns u.
    steps : list of Formula and Elimination
        The computation of the unknowns, in this order; see `algebra.solved`.

    Raises
    ------
    ValueError
        In one sentence: symbols that nobody declared, too few equations, equations or constraints
        that contradict each other or depend on each other, a start that violates the constraints.
    """

    def __init__(self, model, law, at_rest=frozenset()):
        if not model.bodies:
            raise ValueError(f"{model.name} has no body: nothing to move.")
        if not model.coordinate_list:
            raise ValueError(f"{model.name} has no coordinates.")
        self.model = model
        self.law = law
        self.at_rest = at_rest
        resting = [one for one in model.contacts if one.name in at_rest]
        held = [Reaction(one.held, one.names[0], "N") for one in resting]
        senses = [one.sense for one in model.contacts if one.name not in at_rest]
        reactions = [*model.reaction_list, *held]
        self.motion = Motion(model.coordinate_list, model.inputs, reactions, senses)
        refuse_impossible_bodies(self, {one.symbol: sp.Float(one.default) for one in model.numbers})
        self.bodies = [laws.Moving(self, body) for body in model.bodies]
        self.held = [one for c in model.constraints if (one := self._held(c))]
        self.start = Start(model, self.motion, self.held)  # before contacts rest
        slips = [Constraint(one.slip, one.names[1], "m/s") for one in resting]
        self.held = self.held + [one for c in slips if (one := self._held(c))]
        self.potential = self.plain(sum(model.energies, start=sp.S.Zero)) - sum(
            (one.mass * self.plain(model.field).dot(one.r) for one in self.bodies),
            start=sp.S.Zero,
        )
        self.kinetic = shortened(sum((one.kinetic() for one in self.bodies), start=sp.S.Zero))
        self.formula = Formulas(self.motion)
        self.laws = laws.newton(self) if law == "newton" else laws.lagrange(self)
        self.points = Points(self)
        self.unknowns = [*self.motion.a, *self.laws.reactions]
        self.K, self.r = determined(self)
        self.steps = solved(self.K, self.r, self.unknowns, LIMIT)
        if not at_rest:
            warn_of_traps(self)

    def plain(self, expression):
        """An expression in plain symbols; raises ValueError for undeclared symbols."""
        if isinstance(expression, sp.MatrixBase):
            return expression.applyfunc(self.plain)
        motion = self.motion
        found = motion.symbols(expression).doit()
        known = {now, *motion.plain.values(), *motion.senses}
        known |= {one.symbol for one in self.model.numbers}
        unknown = sorted(map(str, found.free_symbols - known))
        unknown += sorted(map(str, found.atoms(sp.Derivative, sp.core.function.AppliedUndef)))
        if unknown:
            raise ValueError(
                f"{self.model.name} uses {unknown[0]}, which is none of its coordinates, "
                "parameters and reactions."
            )
        printed(found)
        return found

    def _held(self, constraint):
        """The HeldConstraint of a constraint; None if all coordinates satisfy the constraint."""
        motion = self.motion
        residual = shortened(self.plain(constraint.expression))
        if residual == 0:
            return None
        if residual.free_symbols & {*motion.a, *motion.reactions}:
            raise ValueError(
                f"The constraint `{constraint.name}` is of positions or velocities; fastdyn "
                "differentiates it."
            )
        on_positions = not residual.free_symbols & {*motion.v}
        velocity = motion.rate(residual) if on_positions else residual
        row, b = linear([motion.rate(velocity)], motion.a)
        if not any(row):
            raise ValueError(
                f"The constraint `{constraint.name}`, {constraint.expression} = 0, says nothing of "
                "the motion: no coordinate is in it."
            )
        position = residual if on_positions else None
        return HeldConstraint(
            constraint.name, constraint.unit, position, velocity, row, shortened(b[0])
        )

    def forces(self, body):
        """The forces on a body, with the friction of its contacts."""
        rubbing = [one for one in self.model.contacts if one.body is body]
        sizes = [one.size(one.name in self.at_rest) for one in rubbing]
        friction = [
            Force((size * one.along).as_immutable(), one.place)
            for one, size in zip(rubbing, sizes, strict=True)
        ]
        return [*body.forces, *friction]

    def explain(self):
        """The nine steps of the derivation, an `Explanation`, to print or to show in a notebook."""
        return Explanation(self)

    def residuals(self):
        """The equations that determine the unknowns, as expressions that are zero."""
        return list(self.K * sp.Matrix(self.unknowns) - self.r)

    def reaction_units(self):
        """The reactions that are known along the motion, with their units."""
        units = {one.name: one.unit for one in self.model.reaction_list}
        units |= {one.names[0]: "N" for one in self.model.contacts}
        return [(one, units.get(str(one), "")) for one in self.laws.reactions]

    @functools.cached_property
    def system(self) -> Any:
        from .friction.system import RubbingSystem
        from .system import DerivedSystem, system_of

        return system_of(self, RubbingSystem if self.model.contacts else DerivedSystem)
