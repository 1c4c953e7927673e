"""Vehicle steered by its driver, a non-holonomic system (course 3.3.4)."""

import dataclasses
import math
from typing import Any, ClassVar

import numpy as np

from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.plot import driving

from .base import State, System, constraint, parameter, quantity
from .base.driver import driver_of


def drunk(t, w):
    """The course's driver: swerves, foot to the floor; (alpha, alpha', P)."""
    return 0.1 + 0.2 * math.sin(t), 0.2 * math.cos(t), 0.2


def steady(t, w):
    """A driver who holds the wheel; (alpha, alpha', P)."""
    return 0.1, 0.0, 0.2


def tight(t, w):
    """A driver who holds the wheel at twice the angle of `steady`; (alpha, alpha', P)."""
    return 0.2, 0.0, 0.2


def coasting(t, w):
    """A driver who steers as the drunk one and gives no gas; (alpha, alpha', P)."""
    return 0.1 + 0.2 * math.sin(t), 0.2 * math.cos(t), 0.0


def _answer(driver, start):
    """The values of a driver at the start; zeros where it raises, which a solve will tell."""
    try:
        return driver(0.0, np.array(start))
    except Exception:
        return (0.0, 0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class Vehicle(System):
    """
    Car on two wheels that roll and do not slip sideways, its mass amidships.

    Equations of motion, with th the heading, alpha(t) the angle of the front wheel, P the thrust
    at the rear wheel, v the speed, and R1, R2 the forces on the wheels along their axles::

        m x'' =  P cos th - c v vx + R1 sin(th + alpha) + R2 sin th
        m y'' = -P sin th - c v vy + R1 cos(th + alpha) + R2 cos th
        0 = R1 cos alpha - R2
        vx sin th + vy cos th + (L/2) th' = 0                                        (rear)
        vx sin(th + alpha) + vy cos(th + alpha) - (L/2) cos(alpha) th' = 0           (front)

    The last two are differentiated once, so that they hold for the accelerations.
    State ``[x, y, th, vx, vy, omega]`` in m, rad, m/s and rad/s with omega = th'; from rest at the
    origin. Defaults and t = 120 s are those of the course's script.

    Parameters
    ----------
    driver : callable
        ``driver(t, w)``, any function of the time and the state, or the chapter's ``driver(t)``:
        returns the angle of the front wheel, rad, its rate, rad/s, and the thrust P, N. By default
        the course's drunk driver, `drunk`; `steady`, `coasting` and `tight` are there too.

    Notes
    -----
    The front wheel must start where the driver holds it: a start in motion needs a velocity that
    both wheels allow, see `rolling`. At constant alpha and thrust the mass ends on a circle, see
    `circle_radius`, at a constant speed, see `terminal_speed`.
    """

    name = "vehicle"
    title = "Vehicle with a driver"
    source = "course 3.3.4"
    states = (
        State("x", "m", "position"),
        State("y", "m", "position across"),
        State("th", "rad", "heading, clockwise"),
        State("vx", "m/s", "velocity"),
        State("vy", "m/s", "velocity across"),
        State("omega", "rad/s", "rate of the heading"),
    )
    t_end = 120.0
    choices: ClassVar = {
        "driver": {"drunk": drunk, "steady": steady, "coasting": coasting, "tight": tight}
    }

    m: float = parameter(1.0, "kg", "mass", positive=True)
    L: float = parameter(1.0, "m", "wheelbase", positive=True)
    c: float = parameter(0.1, "kg/m", "drag coefficient", negative=False)
    driver: Any = drunk

    def __post_init__(self):
        super().__post_init__()
        about = (
            "`driver` of the vehicle must be a function of (t, w), or of t, that returns the angle "
            "of the front wheel, its rate, and the thrust"
        )
        object.__setattr__(self, "driver", driver_of(self.driver, about))
        answer = _answer(self.driver, self.initial_state())
        if np.size(answer) != 3:
            raise ValueError(
                "`driver` of the vehicle must return three numbers: the angle of the front wheel, "
                f"its rate, and the thrust; it returned {answer!r}."
            )

    def initial_state(self):
        """At rest at the origin, heading along x."""
        return (0.0,) * 6

    @staticmethod
    def rhs(t, w, m, L, c, driver):
        ax, ay, spin, _, _ = motion(t, w, m, L, c, driver)
        return [w[3], w[4], w[5], ax, ay, spin]

    @staticmethod
    def project(t, w, m, L, c, driver):
        """The nearest velocity that both wheels allow, at the same place."""
        x, y, th, vx, vy, omega = w
        alpha, _, _ = driver(t, w)
        s = math.sin(th)
        cs = math.cos(th)
        sf = math.sin(th + alpha)
        cf = math.cos(th + alpha)
        half = 0.5 * L
        ca = math.cos(alpha)
        slip = (sf * vx + cf * vy - half * ca * omega, s * vx + cs * vy + half * omega)
        rows = ((sf, cf, -half * ca), (s, cs, half))
        dx, dy, spin, _, _ = constrained((1.0, 1.0, L * L), rows, (0.0, 0.0, 0.0), slip)
        return [x, y, th, vx - dx, vy - dy, omega - spin]

    @quantity("m/s", "speed")
    def speed(t, w, m, L, c, driver):
        """Magnitude of the velocity of the mass."""
        return np.sqrt(w[3] * w[3] + w[4] * w[4])

    @quantity("J", "kinetic energy")
    def kinetic_energy(t, w, m, L, c, driver):
        """m v²/2; constant without thrust and drag, since the wheels' reactions do no work."""
        return 0.5 * m * (w[3] * w[3] + w[4] * w[4])

    @quantity("N", "front wheel force R1")
    def front_force(t, w, m, L, c, driver):
        """Reaction of the road on the front wheel, along its axle."""
        return motion(t, w, m, L, c, driver)[3]

    @quantity("N", "rear wheel force R2")
    def rear_force(t, w, m, L, c, driver):
        """Reaction of the road on the rear wheel, along its axle."""
        return motion(t, w, m, L, c, driver)[4]

    @constraint("m/s", "sideways velocity of the front wheel")
    def front_slip(t, w, m, L, c, driver):
        """Velocity of the front wheel along its axle, which the road forbids."""
        alpha, _, _ = driver(t, w)
        direction = w[2] + alpha
        across = math.sin(direction) * w[3] + math.cos(direction) * w[4]
        return across - 0.5 * L * math.cos(alpha) * w[5]

    @constraint("m/s", "sideways velocity of the rear wheel")
    def rear_slip(t, w, m, L, c, driver):
        """Velocity of the rear wheel along its axle, which the road forbids."""
        return math.sin(w[2]) * w[3] + math.cos(w[2]) * w[4] + 0.5 * L * w[5]

    def rolling(self, speed) -> tuple[float, ...]:
        """State at the origin, heading along x, that rolls at a speed in m/s at t = 0."""
        alpha, _, _ = self.driver(0.0, self.initial_state())
        slip = -0.5 * math.tan(alpha)  # vy / vx amidships
        vx = speed / math.hypot(1.0, slip)
        return (0.0, 0.0, 0.0, vx, slip * vx, -2.0 * slip * vx / self.L)

    def circle_radius(self, alpha) -> float:
        """Radius of the circle that the mass describes at a constant angle of the wheel, m.

        Notes
        -----
        The axles meet at the centre, L / tan alpha beside the rear wheel and half a wheelbase
        behind the mass: radius² = (L / tan alpha)² + (L/2)².
        """
        return math.hypot(self.L / math.tan(alpha), 0.5 * self.L)

    def terminal_speed(self, alpha, P) -> float:
        """Speed in m/s at which drag balances the thrust P (N) at a constant angle alpha (rad).

        Notes
        -----
        The thrust does work at the speed of the rear wheel, v / hypot(1, tan(alpha)/2); drag takes
        c v² at the speed v.
        """
        return math.sqrt(P / (self.c * math.hypot(1.0, 0.5 * math.tan(alpha))))

    def figure(self, results, **options):
        """Path, beside speed and wheel forces against time; see `System.figure`."""
        return driving.figure(results, **options)

    def scene(self, t, w):
        """The car from above; see `System.scene`."""
        return driving.scene(self, t, w)


def motion(t, w, m, L, c, driver):
    """Accelerations and reactions, (x'', y'', th'', R1, R2)."""
    _, _, th, vx, vy, omega = w
    alpha, turn, P = driver(t, w)
    s = math.sin(th)
    cs = math.cos(th)
    sf = math.sin(th + alpha)
    cf = math.cos(th + alpha)
    ca = math.cos(alpha)
    half = 0.5 * L
    v = math.sqrt(vx * vx + vy * vy)
    front = (-cf * vx + sf * vy) * (omega + turn) - math.sin(alpha) * half * omega * turn
    return constrained(
        ((m, 0.0, 0.0), (0.0, m, 0.0), (0.0, 0.0, 0.0)),  # the chassis has no mass
        ((sf, cf, -half * ca), (s, cs, half)),
        (P * cs - c * v * vx, -P * s - c * v * vy, 0.0),
        (front, (-cs * vx + s * vy) * omega),
    )
