"""Rigid bodies: their rotation, and their moments of inertia."""

from typing import Any

import sympy as sp

from .bodies import Body, Force
from .notation import ZERO, Rotation, dot, k, rotation, vector


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
        self.inertia = [sp.sympify(one) for one in inertia]
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
