"""Particles and rigid bodies, and the forces that are drawn on them."""

from typing import Any, NamedTuple

import sympy as sp
from sympy.core.function import AppliedUndef

from .checks.inputs import refuse_negative
from .friction.contact import Contact
from .notation import (
    ZERO,
    OfTime,
    Rotation,
    cross,
    direction,
    dot,
    expression,
    k,
    length,
    rate,
    rotation,
    stays,
    vector,
)


class Force(NamedTuple):
    """A force on a body at a point, or a torque (`at` is None); `potential` if it has an energy."""

    vector: Any
    at: Any
    potential: bool = False


class Point(NamedTuple):
    """A point of a body, or of the ground (`body` is None)."""

    body: "Body | None"
    position: Any


class Body:
    """
    A particle, or a rigid body, of a model; `Model.particle` and `Model.body` make them.

    Attributes
    ----------
    name : str
        The name in explanations and errors.
    mass : expression
        May be 0.
    position : vector
        The centre of mass.
    """

    def __init__(self, model, name, mass, position):
        self.model = model
        self.name = name
        self.mass = expression(mass, f"the mass of {name}")
        self.position = vector(position, f"the position of {name}")
        self.forces: list[Force] = []

    omega: Any = ZERO
    rigid = False

    def momentum(self) -> Any:
        """Angular momentum about the centre of mass."""
        return ZERO

    def to_laws(self):
        """The rotation from the fixed frame to the frame of the equations of the body."""
        return Rotation()

    def at(self, position):
        """The point of the body at a position, a vector, as an end of a spring or damper."""
        return Point(self, self._place(position))

    def velocity(self, at=None) -> Any:
        """The velocity of the point of the body at a position, by default the centre of mass."""
        return rate(self.position) + cross(self.omega, self._place(at) - self.position)

    def force(self, force, at=None):
        """
        Draw a force.

        Parameters
        ----------
        force : vector
            A vector in the fixed frame; reactions may be factors.
        at : vector, optional
            The point of action; by default the centre of mass.
        """
        self.forces.append(Force(vector(force, "a force"), self._place(at)))
        reactions = [one.function for one in self.model.reaction_list]
        if at is not None and self.forces[-1].vector.has(*reactions):
            self.model.draw("held", self.at(at))  # a reaction tells where a body is held

    def drag(self, c, wind=0):
        """Draw the drag -c \\|u\\| u; u is the velocity relative to the vector `wind`."""
        u = rate(self.position) - vector(wind, "the wind")
        self.force(-sp.sympify(c) * length(u) * u)

    def rolls(self, *directions, at=None, reactions=(), over=0):
        """
        Forbid slip: the point of the body at a place has no velocity along some directions.

        Parameters
        ----------
        *directions : vector
            One constraint each, on velocities.
        at : vector, optional
            The point of contact, as a position; by default the centre of mass.
        reactions : sequence of expression, optional
            The size of the reaction along each direction; none for Lagrange's multipliers.
        over : vector
            The velocity of the ground.

        Raises
        ------
        ValueError
            If the number of reactions is not the number of directions.
        """
        self._holds(directions, at, reactions, over)
        held = self.model.constraints
        held[-len(directions) :] = [one._replace(rolling=self) for one in held[-len(directions) :]]
        edge = directions[0] if len(directions) == 1 else None
        self.model.draw("edge", self.at(at), across=edge)

    def _holds(self, directions, at, reactions, over):
        """The constraints and reactions of `rolls`."""
        reactions = [reactions] if isinstance(reactions, sp.Basic) else list(reactions)
        if reactions and len(reactions) != len(directions):
            raise ValueError(
                f"{len(directions)} directions in which {self.name} does not slip have as many "
                f"reactions; got {len(reactions)}."
            )
        slip = self.velocity(at) - vector(over, "the velocity of the ground")
        for n, given in enumerate(directions):
            along = direction(given, "a direction")
            self.model.constrain(dot(slip, along), self.model.free_name("slip"), "m/s")
            if reactions:
                self.force(reactions[n] * along, at)

    def slides(
        self,
        normal,
        reaction,
        *,
        at=None,
        over=0,
        through=None,
        friction=0,
        static=None,
        along=None,
        guided=False,
    ):
        """
        Touch a surface: no velocity along the normal, and friction along the slip.

        Parameters
        ----------
        normal : vector
            The direction from the surface to the body, of any length.
        reaction : expression
            The size of the normal force, positive where the surface pushes.  A run warns of a
            negative force, unless the body is `guided` on both sides.
        at, over
            As for `rolls`.
        through : vector, optional
            A point of the surface.  The body is held on the surface through this point, and a start
            off the surface is moved to the surface, or refused.  By default the surface goes
            through the start.
        friction : expression
            The coefficient of friction.  The friction acts against the slip.  At rest, the friction
            takes any size up to the coefficient times the normal force; events switch between slip
            and rest.
        static : expression, optional
            The coefficient at rest, if greater than `friction`.
        along : vector, optional
            The direction of slip, required with `friction`.
        guided : bool
            True if the reaction may have either sign.
        """
        over = vector(over, "the velocity of the ground")
        place = self._place(at)
        normal = direction(normal, "the normal")
        if through is None:
            self._holds([normal], at, [reaction], over)
        else:
            through = vector(through, "a point of the surface")
            gap = dot(place - through, normal)
            self.model.constrain(gap, self.model.free_name("gap"))
            self.force(reaction * normal, at)
        self.model.draw("surface", self.at(at), across=normal)
        if isinstance(reaction, OfTime) and not guided:
            self.model.pushing[reaction.func.__name__] = self.name
        if friction != 0:
            if along is None:
                raise ValueError("friction needs `along`, the direction in which the body slips.")
            along = direction(along, "the direction of slip")
            both = (friction, static or friction)
            refuse_negative(f"of {self.name}", friction, static)
            slip = dot(self.velocity(at) - over, along)
            self.model.rubs(Contact.of(self, reaction, both, along, place, slip))

    def _place(self, position):
        if position is None:
            return self.position
        return vector(position, f"a point of {self.name}")


class Particle(Body):
    """A point with a mass."""

    def _place(self, position):
        place = super()._place(position)
        if (place - self.position).applyfunc(sp.simplify) != ZERO:
            raise ValueError(
                f"{self.name} is a particle, but something acts at another place than its own, "
                f"{list(place)}: make it a body."
            )
        return place


def point(given):
    """The Point of an end of a spring: a body, a point of a body, or a place."""
    if isinstance(given, Point):
        return given
    if isinstance(given, Body):
        return given.at(None)
    return Point(None, vector(given, "an end of a spring"))


def between(a, b, along) -> Any:
    """The points a and b, their distance, and the direction from a to b."""
    a = point(a)
    b = point(b)
    if a.body is None and b.body is None:
        raise ValueError("a spring or a force between two places moves nothing.")
    d = b.position - a.position
    if stays(dot(d, d)) if along is None else stays(dot(d, vector(along, "`along`"))):
        raise ValueError(
            "a spring or a force between two points whose distance never changes has no effect: "
            f"they are {list(a.position)} and {list(b.position)}."
        )
    if along is None:
        return a, b, length(d), d / length(d)
    along = direction(along, "`along`")
    if along.atoms(AppliedUndef):
        raise ValueError(
            "`along` of a spring is a direction that does not turn with the coordinates; "
            "without it the spring acts along the line between its ends."
        )
    return a, b, dot(d, along), along


def pull(a, b, force, potential=False):
    """Draw a force on the body at a, and the opposite force on the body at b."""
    for (body, place), one in ((a, force), (b, -force)):
        if body is not None:
            body.forces.append(Force(one.as_immutable(), place, potential))


class RigidBody(Body):
    """A body that turns; `inertia` is about the centre of mass, in the frame of the body."""

    rigid = True

    def __init__(self, model, name, mass, position, inertia, turned):
        super().__init__(model, name, mass, position)
        if not isinstance(turned, Rotation):
            turned = rotation(turned, k)
        self.rotation = turned
        self.omega = turned.angular_velocity().applyfunc(sp.expand)
        if not isinstance(inertia, tuple | list):
            inertia = (0, 0, inertia)
            if any(axis != k for _, axis in turned.turns):
                raise ValueError(
                    f"{self.name} turns in space: it has three moments of inertia, about its axes."
                )
        if len(inertia) != 3:
            raise ValueError(f"{self.name} has three principal moments of inertia; got {inertia}.")
        self.inertia = [expression(one, f"a moment of inertia of {name}") for one in inertia]
        if any(self.inertia):
            self._turns("a moment of inertia")

    def _turns(self, what):
        """Refuse a torque or an inertia, which have no effect on a body that does not turn."""
        if self.omega == ZERO:
            raise ValueError(
                f"{self.name} has {what}, but it does not turn: give its angle, "
                "`body(..., turned=angle)`, or make it a particle."
            )

    def torque(self, torque):
        """Draw a torque, a vector in the fixed frame."""
        self._turns("a torque")
        self.forces.append(Force(vector(torque, "a torque"), None))

    def to_laws(self):
        """The rotation to the frame of Euler's law: the frame of the body, unless symmetric."""
        return self.rotation.inverse() if len({*self.inertia}) == 3 else Rotation()

    def momentum(self) -> Any:
        a, b, c = self.inertia
        for axis, alone, pair in ((2, c, (a, b)), (1, b, (a, c)), (0, a, (b, c))):
            if pair[0] == pair[1]:  # the spin about its axis does not appear
                e = self.rotation * sp.eye(3).col(axis)
                return pair[0] * self.omega + (alone - pair[0]) * dot(self.omega, e) * e
        axes = [self.rotation * sp.eye(3).col(n) for n in range(3)]
        return sum(
            (one * dot(self.omega, e) * e for one, e in zip(self.inertia, axes, strict=True)),
            start=ZERO,
        )
