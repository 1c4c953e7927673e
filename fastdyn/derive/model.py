"""A model as a blackboard shows the model: bodies, forces, constraints, a start."""

from typing import Any

import sympy as sp

from fastdyn.words.kinds import number

from .bodies import Body, Particle, RigidBody, between, point, pull
from .checks.inputs import component_of, refuse_unknown_unit, residual_of
from .declarations import Constraint, Declarations, Drawn, UserDeclaration
from .derivation import Derivation
from .friction.contact import Contact
from .notation import ZERO, expression, rate, vector


class Model(Declarations):
    """
    A mechanical system, drawn and written as on a blackboard.

    Parameters
    ----------
    name : str
        An identifier, for explanations, errors and the command line.
    title : str
        A heading.
    source : str
        The book or script that the system is from.
    t_end : float
        Default end of the run, s.

    Examples
    --------
    >>> from fastdyn.derive import Model, j
    >>> ball = Model("ball")
    >>> z = ball.coordinates("z")
    >>> m, g = ball.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"))
    >>> _ = ball.particle(m, z * j)
    >>> ball.gravity(-g * j)
    >>> ball.newton().system(g=1.62).solve((0, 1)).y[0, -1]  # doctest: +ELLIPSIS
    np.float64(-0.81...)
    """

    def __init__(self, name, title="", source="", t_end=10.0):
        super().__init__(name)
        number("t_end", t_end)
        self.title, self.source, self.t_end = title or name, source, float(t_end)
        self.bodies: list[Body] = []
        self.constraints: list[Constraint] = []
        self.functions: list[UserDeclaration] = []
        self.contacts: list[Contact] = []
        self.drawn: list[Drawn] = []
        self.lengths: list[Any] = []  # lengths of springs and others along their own direction
        self.pushing: dict[str, str] = {}  # reactions that push, and the bodies that they push
        self.field = ZERO
        self.energies: list[sp.Expr] = []
        self.given: dict[str, Any] = {}
        self.guesses: dict[str, Any] = {}

    # -- bodies

    def particle(self, mass, position, name="") -> Any:
        """
        A point with a mass, a `Particle`.

        Parameters
        ----------
        mass : expression
        position : vector
            For example ``x*i + y*j``.
        name : str, optional
        """
        return self._add(Particle(self, name or self._numbered("mass"), mass, position))

    def body(self, mass, position, inertia: Any = 0, turned: Any = 0, name="") -> Any:
        """
        A rigid body, a `RigidBody`.

        Parameters
        ----------
        mass : expression
        position : vector
            The centre of mass.
        inertia : expression or tuple of three
            Moment of inertia about k through the centre of mass; in space, the three moments about
            the axes of the body.
        turned : expression or Rotation
            Angle about k, counterclockwise; or the rotation from the frame of the body.
        name : str, optional
        """
        name = name or self._numbered("body")
        return self._add(RigidBody(self, name, mass, position, inertia, turned))

    # -- forces that have an energy, and between bodies

    def gravity(self, g):
        """Let all bodies have weight; the vector `g` is the acceleration of gravity."""
        self.field = vector(g, "the acceleration of gravity")

    def spring(self, a, b, stiffness, natural=0, along=None):
        """
        Draw a linear spring between two points.

        Parameters
        ----------
        a, b : Body, Point or vector
            The ends: centres of bodies, points of bodies (`Body.at`), or fixed places.
        stiffness : expression
            Force over elongation.
        natural : expression
            Length without load.
        along : vector, optional
            A fixed direction from a to b.  The length is then measured along this direction, and
            may become negative.
        """
        stiffness = expression(stiffness, "the stiffness of a spring")
        natural = expression(natural, "the natural length of a spring")
        self.central(a, b, lambda r: stiffness * (r - natural) ** 2 / 2, along)
        self.draw("spring", a, b)

    def central(self, a, b, energy, along=None):
        """
        Draw a central force between two points: see `spring` for `a`, `b` and `along`.

        ``energy(r)`` is the potential energy, an expression of the distance r.
        """
        a, b, r, direction = self._between(a, b, along)
        x = sp.Symbol("r", positive=True)
        force = sp.diff(energy(x), x).subs(x, r)
        pull(a, b, force * direction, potential=True)
        self.energies.append(energy(x).subs(x, r))
        self.draw("force", a, b)

    def damper(self, a, b, c, along=None):
        """Draw a damper: a force of c times the rate of the distance of a and b, see `spring`."""
        a, b, r, direction = self._between(a, b, along)
        pull(a, b, expression(c, "the constant of a damper") * rate(r) * direction)
        self.draw("damper", a, b)

    # -- pictures

    def line(self, *points):
        """
        Draw a line in pictures through bodies, points of bodies (`Body.at`), or places.

        Pictures show rods, hinges and cables without a line, because the motion keeps their
        lengths.  Draw a line for other things, such as a rail, or a rod to a moving pivot.
        """
        if len(points) < 2:
            raise ValueError("a line goes through two points or more.")
        self.draw("line", *points)

    def guide(self, body):
        """
        Draw the curve on which a particle slides, such as the hoop of a bead.

        Pictures draw wires and other curves without being told.  Only a circle may be the hoop of a
        bead as well as the way of a pendulum, which has a rod: tell by `guide` that it is a hoop.

        Parameters
        ----------
        body : Particle
            Its position follows from one coordinate, or constraints leave one.
        """
        if not isinstance(body, Particle) or body.model is not self:
            raise TypeError(f"`body` must be a particle of {self.name}; got {body!r}.")
        self.draw("guide", body)

    def draw(self, kind, *points, across=None):
        """Add a drawing to the pictures of the system: see `Drawn`."""
        self.drawn.append(Drawn(kind, tuple(map(point, points)), across))

    # -- constraints, start, and what else is asked for

    def constrain(self, expression, name="", unit="m"):
        """
        Constrain the motion: an expression of positions, or also of velocities, is zero.

        Parameters
        ----------
        expression : expression
            An expression of coordinates, or of coordinates and their rates (``rate(x)``), linear in
            the rates; or an equation ``Eq(a, b)``.
        name, unit : str
            Name and unit of the residual.
        """
        expression = residual_of(expression)
        name = name or self.free_name("constraint")
        refuse_unknown_unit(name, unit)
        self.declare(name, f"{name}_rate", f"lambda_{name}")
        self.constraints.append(Constraint(expression, name, unit))

    def rubs(self, contact):
        """Add a contact with friction: see `Body.slides`."""
        self.declare(*contact.names)
        self.contacts.append(contact)

    def start(self, **values):
        """
        Set the state at t = 0, by the names of coordinates and rates, in SI units.

        A value is a number, or an expression of the model's numbers.  Components without a value
        are 0; with constraints, Newton's iteration from `guess` finds these components.
        """
        self.given |= self._of_state(values)

    def guess(self, **values):
        """Guess components of the start that the constraints determine; without a guess, 0."""
        self.guesses |= self._of_state(values)

    def quantity(self, name, expression, unit="", label=""):
        """Define an output: an expression of coordinates, rates, reactions, numbers and time."""
        self._function("quantity", name, expression, unit, label)

    def invariant(self, name, expression, unit="", label=""):
        """Define an output as `quantity` does; checks of a run test that the output is constant."""
        self._function("invariant", name, expression, unit, label)

    def event(self, name, expression, *, direction=0, terminal=False):
        """Define an event: zeros of an expression, for ``solve(events=name)``; see `solve_ivp`."""
        about = {"direction": direction, "terminal": terminal}
        self._function("event", name, expression, "", "", about)

    # -- equations of motion

    def derive(self):
        """Equations of motion by Newton's laws if reactions are drawn, else by Lagrange's."""
        return self.newton() if self.reaction_list else self.lagrange()

    def newton(self):
        """Equations of motion from Newton's and Euler's laws for each body, a `Derivation`."""
        return Derivation(self, "newton")

    def lagrange(self):
        """
        Equations of motion from Lagrange's equations, a `Derivation`.

        Reactions that are drawn contribute their work.  If no drawn reaction does work, each
        constraint has a multiplier.
        """
        return Derivation(self, "lagrange")

    def _add(self, body) -> Any:
        self.bodies.append(body)
        return body

    def _numbered(self, kind):
        """The name of a body without a given name."""
        same = sum(one.name.startswith(kind) for one in self.bodies)
        return f"{kind} {same + 1}" if same else kind

    def _between(self, a, b, along) -> Any:
        found = between(a, b, along)
        if along is None:
            self.lengths.append(found[2])
        return found

    def _of_state(self, values):
        known = {one.name: one.unit for one in self.coordinate_list}
        known |= {one.rate: f"{one.unit or 1}/s" for one in self.coordinate_list}
        for name in values:
            if name not in known:
                raise ValueError(f"`{name}` is no part of the state ({', '.join(known)}).")
        return {name: component_of(name, value, known[name]) for name, value in values.items()}

    def _function(self, kind, name, expression, unit="", label="", event=None):
        refuse_unknown_unit(name, unit)
        self.declare(name)
        one = UserDeclaration(kind, name, sp.sympify(expression), unit, label, event or {})
        self.functions.append(one)
