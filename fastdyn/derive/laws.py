"""Newton's and Euler's laws for each body, and Lagrange's equations."""

from typing import Any, NamedTuple

import sympy as sp

from .algebra import shortened
from .notation import ZERO, Rotation


class Moving:
    """The position, motion and forces of a body, in plain symbols."""

    def __init__(self, derivation, body):
        plain = derivation.plain
        rate = derivation.motion.rate
        self._v = derivation.motion.v
        self.derivation = derivation
        self.body, self.name, self.mass = body, body.name, plain(body.mass)
        self.r = plain(body.position)
        self.v: Any = shortened(rate(self.r))
        self.acceleration: Any = shortened(rate(self.v))
        self.to_laws = Rotation(*((plain(a), axis) for a, axis in body.to_laws().turns))
        self.axes = "123" if self.to_laws.turns else "ijk"
        self.omega: Any = shortened(self.to_laws * plain(body.omega))
        self.momentum: Any = shortened(self.to_laws * plain(body.momentum()))
        self.weight = self.mass * plain(derivation.model.field)
        self.forces = list(map(self._drawn(plain), derivation.forces(body)))
        self.turning: Any = ZERO
        if body.rigid:
            self.turning = rate(self.momentum)
            if self.to_laws.turns:
                self.turning += self.omega.cross(self.momentum)
            self.turning = shortened(self.turning)

    def _drawn(self, plain):
        def drawn(force):
            at = None if force.at is None else plain(force.at)
            return force._replace(vector=plain(force.vector), at=at)

        return drawn

    def kinetic(self):
        """Kinetic energy."""
        return self.mass * self.v.dot(self.v) / 2 + self.omega.dot(self.momentum) / 2

    def resultant(self) -> Any:
        """The sum of all forces, and of all torques about the centre of mass."""
        force = self.weight
        torque = ZERO
        for one in self.forces:
            if one.at is None:
                torque += one.vector
            else:
                force += one.vector
                torque += (one.at - self.r).cross(one.vector)
        return force, shortened(self.to_laws * torque)

    def partial(self):
        """The derivatives of velocity and angular velocity by the rates: two 3 x n matrices."""
        return self.v.jacobian(self._v), self.omega.jacobian(self._v)

    def work(self, force):
        """The generalized forces of one force: its work in a change of each coordinate."""
        v, omega = self.partial()
        if force.at is None:
            return omega.T * (self.to_laws * force.vector)
        torque = self.to_laws * (force.at - self.r).cross(force.vector)
        return v.T * force.vector + omega.T * torque


class Law(NamedTuple):
    """One equation: its name, and its two sides."""

    name: str
    left: Any
    right: Any

    @property
    def residual(self):
        return self.left - self.right


class Laws(NamedTuple):
    """
    Equations of motion before the constraints.

    `written` are the equations on the blackboard.  `candidates` are combinations of these
    equations; the equations that determine the unknowns are chosen from them, in this order.
    `reactions` are the unknown reactions in the equations.
    """

    written: list[Law]
    candidates: list[Any]
    reactions: list[sp.Symbol]


def newton(derivation):
    """Newton's and Euler's laws, and their components along the motions and the reactions."""
    motion = derivation.motion
    written = []
    balances = []
    for one in derivation.bodies:
        force, torque = one.resultant()
        v, omega = one.partial()
        balances.append((one.mass * one.acceleration - force, v, force))
        for axis, left, right in zip("ijk", one.mass * one.acceleration, force, strict=True):
            written.append(Law(f"Newton's law of {one.name} along {axis}", left, right))
        if one.body.rigid:
            balances.append((one.turning - torque, omega, torque))
            for axis, left, right in zip(one.axes, one.turning, torque, strict=True):
                written.append(Law(f"Euler's law of {one.name} about {axis}", left, right))
    written = [law for law in written if law.left != 0 or law.right != 0]
    moving = [
        sum(balance.dot(partial.col(n)) for balance, partial, _ in balances)
        for n in range(len(motion.q))
    ]
    working: Any = sp.Matrix([shortened(sp.expand(one)) for one in moving])
    idle = [R for R in motion.reactions if not working.has(R)]  # reactions without work
    ordered = [*idle, *(R for R in motion.reactions if R not in idle)]
    reacting = [_reacting(R, balances, motion.reactions) for R in ordered]
    reacting = [one for one in reacting if one is not None]
    return Laws(written, [*moving, *reacting, *(law.residual for law in written)], motion.reactions)


def _reacting(R, balances, reactions):
    """The balance of forces or torques along a reaction that contains fewest other reactions."""
    drawn = [
        (len(total.free_symbols & {*reactions}), n)
        for n, (_, _, total) in enumerate(balances)
        if R in total.free_symbols
    ]
    if not drawn:
        return None
    balance, _, total = balances[min(drawn)[1]]
    return balance.dot(total.diff(R))


def lagrange(derivation):
    """Lagrange's equations, with the reactions that do work, or with multipliers."""
    motion = derivation.motion
    T = sp.expand(derivation.kinetic)
    V = derivation.potential
    left = [
        motion.rate(sp.diff(T, v)) - sp.diff(T, q) for q, v in zip(motion.q, motion.v, strict=True)
    ]
    forces = sp.Matrix([-sp.diff(V, q) for q in motion.q])
    for one in derivation.bodies:
        for force in one.forces:
            if not force.potential:
                forces += one.work(force)
    forces: Any = shortened(forces)
    working = [R for R in motion.reactions if forces.has(R)]
    if not working:
        _refuse_curved(derivation)
        names = [f"lambda_{one.name}" for one in derivation.held]
        working = [sp.Symbol(name, real=True) for name in names]
        for one, multiplier in zip(derivation.held, working, strict=True):
            forces += multiplier * one.row.T
    written = [
        Law(f"Lagrange's equation of {q}", shortened(a), b)
        for q, a, b in zip(motion.q, left, forces, strict=True)
    ]
    return Laws(written, [law.residual for law in written], working)


def _refuse_curved(derivation):
    """Refuse constraints that are not linear in the velocities: a multiplier has no direction."""
    for one in derivation.held:
        if one.row.free_symbols & {*derivation.motion.v}:
            raise ValueError(
                f"The constraint `{one.name}` of {derivation.model.name} is not linear in the "
                "velocities, so it does not tell the direction of its reaction: draw it."
            )
