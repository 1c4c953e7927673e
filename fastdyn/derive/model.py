"""What stands on the blackboard: bodies, forces, constraints, a start."""

from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from .bodies import Body, Force, Particle, point
from .checks.given import component_of, residual_of
from .declarations import Constraint, Declarations, Drawn, Function
from .derivation import Derivation
from .friction.contact import Contact
from .notation import ZERO, direction, dot, length, rate, vector
from .rigid import RigidBody


class Model(Declarations):
    """
    A mechanical system as it is drawn and written on a blackboard.

    Parameters
    ----------
    name : str
        An identifier, by which explanations, errors and the command line know it.
    title : str
        A heading.
    source : str
        Where it is from.
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
        self.title, self.source, self.t_end = title or name, source, float(t_end)
        self.bodies: list[Body] = []
        self.constraints: list[Constraint] = []
        self.functions: list[Function] = []
        self.contacts: list[Contact] = []
        self.drawn: list[Drawn] = []
        self.lengths: list[Any] = []  # of springs and others, which have a direction
        self.pushing: dict[str, str] = {}  # reactions that push, and the bodies that they push
        self.field = ZERO
        self.energies: list[sp.Expr] = []
        self.given: dict[str, Any] = {}
        self.guesses: dict[str, Any] = {}

    # -- bodies

    def particle(self, mass, position, name="") -> Any:
        """A point with a mass, `Particle`; the position is a vector, as x*i + y*j."""
        return self._add(Particle(self, name or self._numbered("mass"), mass, position))

    def body(self, mass, position, inertia: Any = 0, turned: Any = 0, name="") -> Any:
        """
        A rigid body, `RigidBody`.

        Parameters
        ----------
        mass : expression
        position : vector
            Of the centre of mass.
        inertia : expression or tuple of three
            Moment of inertia about k through the centre of mass; in space those about the three
            axes of the body.
        turned : expression or Rotation
            Angle about k, counterclockwise; or the rotation from the frame of the body.
        """
        name = name or self._numbered("body")
        return self._add(RigidBody(self, name, mass, position, inertia, turned))

    # -- forces that have an energy, and between bodies

    def gravity(self, g):
        """Weight of all bodies: g is the vector of the acceleration of gravity."""
        self.field = vector(g, "the acceleration of gravity")

    def spring(self, a, b, stiffness, natural=0, along=None):
        """
        A spring between two points: bodies, points of them (`Body.at`), or places.

        Parameters
        ----------
        stiffness : expression
        natural : expression
            Length without load.
        along : vector, optional
            Direction from a to b that the spring keeps; its length is then counted along it, and
            may become negative.
        """
        self.central(a, b, lambda r: sp.sympify(stiffness) * (r - natural) ** 2 / 2, along)
        self.draw("spring", a, b)

    def central(self, a, b, energy, along=None):
        """A force between two points with an energy that depends on their distance r alone."""
        a, b, r, direction = self._between(a, b, along)
        x = sp.Symbol("r", positive=True)
        pull = sp.diff(energy(x), x).subs(x, r)
        self._pair(a, b, pull * direction, potential=True)
        self.energies.append(energy(x).subs(x, r))
        self.draw("force", a, b)

    def damper(self, a, b, c, along=None):
        """A damper between two points: a force of c times the rate of their distance."""
        a, b, r, direction = self._between(a, b, along)
        self._pair(a, b, c * rate(r) * direction)
        self.draw("damper", a, b)

    # -- pictures

    def line(self, *points):
        """
        Draw a line in pictures: through bodies, points of them (`Body.at`), or places.

        Rods, hinges and cables are found by the distances that the motion keeps; a line is for
        what is not, as a rail, or a rod to a pivot that is moved.
        """
        if len(points) < 2:
            raise ValueError("a line goes through two points or more.")
        self.draw("line", *points)

    def draw(self, kind, *points, across=None):
        """Take something that pictures show, see `Drawn`."""
        self.drawn.append(Drawn(kind, tuple(map(point, points)), across))

    # -- constraints, start, and what else is asked for

    def constrain(self, expression, name="", unit="m"):
        """
        What is zero: an expression of the positions, or of the velocities too.

        Parameters
        ----------
        expression : expression
            Of coordinates, or of their rates (``rate(x)``), linear in these; ``Eq(a, b)``, too.
        name : str
            Name of the residual.
        unit : str
            Its unit.
        """
        expression, name = residual_of(expression), name or self.free_name("constraint")
        self.declare(name, f"{name}_rate", f"lambda_{name}")
        self.constraints.append(Constraint(expression, name, unit))

    def rubs(self, contact):
        """Take a contact with friction, see `Body.slides`."""
        self.declare(*contact.names)
        self.contacts.append(contact)

    def start(self, **values):
        """
        State at t = 0, by the names of coordinates and rates: numbers, or expressions of numbers.

        What is not given is 0; where there are constraints it is what satisfies them, looked for
        from `guess`.
        """
        self.given |= self._of_state(values)

    def guess(self, **values):
        """Where to look for the part of the start that the constraints determine, from 0 unless
        given."""
        self.guesses |= self._of_state(values)

    def quantity(self, name, expression, unit="", label=""):
        """Something to be known along the motion, an expression of all there is."""
        self._function("quantity", name, expression, unit, label)

    def invariant(self, name, expression, unit="", label=""):
        """As `quantity`, of what the motion keeps; it is checked."""
        self._function("invariant", name, expression, unit, label)

    def event(self, name, expression, *, direction=0, terminal=False):
        """A function whose zeros are events, ``solve(events=name)``."""
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

        The reactions that are drawn do their work in them; where none of them does, each
        constraint has a multiplier.
        """
        return Derivation(self, "lagrange")

    def _add(self, body) -> Any:
        self.bodies.append(body)
        return body

    def _numbered(self, kind):
        """The name of a body that was given none."""
        same = sum(one.name.startswith(kind) for one in self.bodies)
        return f"{kind} {same + 1}" if same else kind

    def _between(self, a, b, along) -> Any:
        """Two points, their distance and the direction from a to b."""
        a, b = point(a), point(b)
        if a.body is None and b.body is None:
            raise ValueError("a spring or a force between two places moves nothing.")
        d = b.position - a.position
        if along is None:
            r = length(d)
            self.lengths.append(r)
            return a, b, r, d / r
        along = direction(along, "`along`")
        if along.atoms(AppliedUndef):
            raise ValueError(
                "`along` of a spring is a direction that does not turn with the coordinates; "
                "without it the spring acts along the line between its ends."
            )
        return a, b, dot(d, along), along

    @staticmethod
    def _pair(a, b, force, potential=False):
        """Draw a force on what is at a, and the opposite one at b."""
        for (body, place), one in ((a, force), (b, -force)):
            if body is not None:
                body.forces.append(Force(one.as_immutable(), place, potential))

    def _of_state(self, values):
        known = {one.name: one.unit for one in self.coordinate_list}
        known |= {one.rate: f"{one.unit or 1}/s" for one in self.coordinate_list}
        for name in values:
            if name not in known:
                raise ValueError(f"`{name}` is no part of the state ({', '.join(known)}).")
        return {name: component_of(name, value, known[name]) for name, value in values.items()}

    def _function(self, kind, name, expression, unit="", label="", event=None):
        self.declare(name)
        one = Function(kind, name, sp.sympify(expression), unit, label, event or {})
        self.functions.append(one)
