"""Branches of periodic orbits over a parameter: continuation by pseudo-arclength.

`Path` takes the steps along the curve of orbits, and finds the special points between them.
"""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import NotConvergedError, count, positive
from .orbit import PeriodicOrbit, orbit_at
from .period import check_period

FAST = 3  # passes of Newton's method after which the step becomes longer
LONGER, SHORTER, SHORTEST = 1.6, 0.5, 1e-6  # factors of the step; its least share of the first
SMALL = 0.02  # amplitude near an equilibrium, as a share of that of the first orbit
STEP = 0.02  # first step, as a share of the range of the parameter
ADVICE = "That is at {} = {:g}: give `period` as a function of the parameter."
CHECKED = (0.0, 0.4, 0.8)  # shares of the way at which the period is compared
NEAR = 1e3  # residual of a corrected point, in units of the tolerance of the solves
PASSES, LOST = 8, 10.0  # most passes of Newton's method; a Newton step that counts as divergence
REFINED = 30  # halvings around a special point


class Special(NamedTuple):
    """A point at which the stability or the direction of a branch changes.

    `kind` is "fold", "period doubling", "branch point" or "torus".
    """

    kind: str
    value: float
    orbit: PeriodicOrbit


class Point(NamedTuple):
    """A point of a branch; u is the scaled vector (state, period if unknown, parameter)."""

    u: np.ndarray
    tangent: np.ndarray
    orbit: PeriodicOrbit


class Path(NamedTuple):
    """The curve of orbits in the space of (state, period if unknown, parameter)."""

    orbit: PeriodicOrbit
    j: int
    start: float
    end: float
    period: Any
    scale: np.ndarray

    @classmethod
    def of(cls, orbit, parameter, end, period):
        """The path of a branch; checks the arguments."""
        if not isinstance(orbit, PeriodicOrbit):
            raise TypeError(f"`orbit` must be a PeriodicOrbit of `periodic_orbit`; got {orbit!r}.")
        j = orbit.equations.parameter(parameter)
        start = orbit.equations.number(j)
        end = float(end)
        if not np.isfinite(end) or end == start:
            raise ValueError(f"`end` must be finite and another value than {start:g}; got {end:g}.")
        if period is None:
            period = _Constant(orbit.period)
        elif not orbit.forced:
            raise ValueError("`period` is for equations that depend on the time.")
        if orbit.forced and abs(period(start) / orbit.period - 1.0) > 1e-9:
            raise ValueError(
                f"`period` gives {period(start):.10g} at {start:g}, but the orbit has the period "
                f"{orbit.period:.10g}."
            )
        if orbit.forced:
            for value in (start + share * (end - start) for share in CHECKED):
                e = orbit.equations.replaced(j, value)
                check_period(e, orbit.t0, orbit.y0, period(value), ADVICE.format(parameter, value))
        size = max(1e-3, float(np.ptp(orbit.y, axis=1).max()))
        scale = np.full(len(orbit.y0), size)
        if not orbit.forced:
            scale = np.append(scale, orbit.period)
        return cls(orbit, j, start, end, period, np.append(scale, abs(end - start)))

    @property
    def sign(self):
        return 1.0 if self.end > self.start else -1.0

    def value(self, point):
        """The parameter at a point."""
        return float(point.u[-1] * self.scale[-1])

    def begin(self):
        """The first Point."""
        y0 = self.orbit.y0
        T = [] if self.orbit.forced else [self.orbit.period]
        u = np.concatenate([y0, T, [self.start]]) / self.scale
        ahead = np.zeros(len(u))
        ahead[-1] = self.sign
        _, matrix, _ = self._equations(u, self._direction(self.orbit))
        return Point(u, _tangent(matrix, ahead), self.orbit)

    def next(self, here, length):
        """(the Point at a distance along the tangent, passes of Newton's method)."""
        guess = here.u + length * here.tangent
        direction = self._direction(here.orbit)
        u = guess
        near = NEAR * self.orbit.flow.options["rtol"]
        for passes in range(1, PASSES + 1):
            off, matrix, passage = self._equations(u, direction, here)
            system = np.vstack([matrix, here.tangent])
            step = np.linalg.lstsq(system, -np.append(off, here.tangent @ (u - guess)), rcond=None)[
                0
            ]
            if np.abs(off).max() <= near and np.abs(step).max() <= 1e-6:
                orbit = self._orbit(u, passage)
                if not orbit.forced and self._direction(orbit) @ direction < 0.0:
                    raise NotConvergedError("The orbit shrinks to an equilibrium there.")
                return Point(u, _tangent(matrix, here.tangent), orbit), passes
            if np.abs(step).max() > LOST:
                break
            u = u + step
        raise NotConvergedError("Newton's method does not come back to the branch.")

    def _orbit(self, u, passage):
        e = self.orbit.equations.replaced(self.j, u[-1] * self.scale[-1])
        orbit = self.orbit
        y, T = self._parts(u)
        return orbit_at(orbit.flow._replace(equations=e), y, T, orbit.t0, orbit.forced, passage)

    def _parts(self, u):
        """State and period."""
        n = len(self.orbit.y0)
        whole = u * self.scale
        return whole[:n], self.period(whole[-1]) if self.orbit.forced else whole[n]

    def _direction(self, orbit):
        rates = orbit.equations.rates(orbit.t0, orbit.y0)
        return rates / max(np.abs(rates).max(), 1e-300)

    def _equations(self, u, direction, here=None):
        """(residuals, their derivatives by u, the Passage)."""
        y, T = self._parts(u)
        n = len(self.orbit.y0)
        p = u[-1] * self.scale[-1]
        e = self.orbit.equations.replaced(self.j, p)
        passage = self.orbit.flow._replace(equations=e).passage(y, self.orbit.t0, T, self.j)
        by_parameter = passage.by_parameter
        off = (passage.y - y) / self.scale[:n]
        rows = [passage.by_start - np.eye(n)]
        if self.orbit.forced:
            h = 1e-5 * max(abs(p), 1e-3)
            slope = (self.period(p + h) - self.period(p - h)) / (2.0 * h)
            by_parameter = by_parameter + slope * passage.by_length
        else:
            rows.append(passage.by_length[:, None])
        matrix = np.hstack([*rows, by_parameter[:, None]]) / self.scale[:n, None]
        if not self.orbit.forced:
            before = y if here is None else here.u[:n] * self.scale[:n]
            off = np.append(off, direction @ (y - before) / self.scale[0])
            matrix = np.vstack([matrix, [*direction / self.scale[0], 0.0, 0.0]])
        return off, matrix * self.scale, passage

    def at_value(self, here, there, value):
        """The Point between two at which the parameter has a value."""
        return self._halved(here, there, lambda p: (self.value(p) - value) * self.sign)

    def _halved(self, here, there, test):
        """The Point between two at which a function changes its sign."""
        low = 0.0
        high = float(here.tangent @ (there.u - here.u))
        begin = test(here) > 0.0
        best = there
        for _ in range(REFINED):
            middle = 0.5 * (low + high)
            if high - low <= 1e-9:
                break
            try:
                point, _ = self.next(here, middle)
            except NotConvergedError:
                break
            if (test(point) > 0.0) == begin:
                low = middle
            else:
                high = middle
                best = point
        return best

    def between(self, here, there, length):
        """The Special points between two neighbours."""
        found = []
        before = min(_outside(here.orbit), _outside(there.orbit))
        tests = {
            "fold": lambda p: p.tangent[-1],
            "period doubling": lambda p: float(np.prod(p.orbit.others() + 1.0).real),
            "branch point": lambda p: float(np.prod(p.orbit.others() - 1.0).real),
            "torus": lambda p: 0.5 - _outside(p.orbit) + before,
        }  # fmt: skip
        for kind, test in tests.items():
            if (test(here) > 0.0) == (test(there) > 0.0):
                continue
            if kind == "branch point" and found and found[0].kind == "fold":
                continue
            point = self._halved(here, there, test)
            found.append(Special(kind, self.value(point), point.orbit))
        return found


class _Constant(NamedTuple):
    """A period that does not depend on the parameter."""

    value: float

    def __call__(self, parameter):
        return self.value


def _outside(orbit):
    """The number of complex multipliers outside the unit circle."""
    others = orbit.others()
    return int((np.abs(others[np.abs(others.imag) > 1e-9]) > 1.0).sum())


def _tangent(matrix, before):
    """The unit tangent of a branch, oriented as the tangent before."""
    vector = np.linalg.svd(matrix)[2][-1]
    return vector if vector @ before >= 0.0 else -vector


@dataclasses.dataclass(frozen=True, repr=False)
class Branch(Displayed):
    """
    Periodic orbits along a branch.

    Attributes
    ----------
    parameter : str
        Name of the parameter.
    values : ndarray, shape (n_orbits,)
        The values of the parameter, which turn back at folds.
    orbits : list of PeriodicOrbit
    special : list of Special
        Folds, period doublings, branch points, and bifurcations of a torus, in their order.
    message : str
        The reason why the branch ends.
    """

    parameter: str
    unit: str
    values: np.ndarray
    orbits: list[PeriodicOrbit]
    special: list[Special]
    message: str

    @property
    def periods(self):
        """Periods, shape (n_orbits,)."""
        return np.array([orbit.period for orbit in self.orbits])

    @property
    def amplitudes(self):
        """Half the range of each component, shape (n, n_orbits)."""
        return np.array([orbit.amplitude for orbit in self.orbits]).T

    @property
    def stable(self):
        """Which orbits are stable, shape (n_orbits,)."""
        return np.array([orbit.stable is True for orbit in self.orbits])

    def __str__(self):
        head = f"Branch of {len(self.orbits)} orbits over {self.parameter}. {self.message}"
        return "\n".join([head, *(f"  {s.kind} at {s.value:.8g}" for s in self.special)])

    @filled()
    def plot(self, component=0, **options) -> Any:
        """Draw the amplitude of a component, and the period, over the parameter.

        Parameters
        ----------
        component : int or name
            The component of the state.
        {figure}
        """
        from fastdyn.plot.analysis.orbits import branch

        return branch(self, component, **options)


@shown_when_wrong(end=kinds.number, largest=kinds.number)
def continuation(orbit, parameter, end, period=None, step=None, n_orbits=200, largest=2.5):
    """Follow a periodic orbit over a parameter, around folds.

    Parameters
    ----------
    orbit : PeriodicOrbit
        A result of `periodic_orbit`, the start of the branch.
    parameter : str or int
        Name of the parameter, or its position among the arguments.
    end : float
        Value towards which the branch is followed. The branch ends at this value, or when the
        parameter returns to its value at the start.
    period : callable, optional
        For equations that depend on the time: the period as a function of the parameter, such as
        ``lambda omega: 2 * math.pi / omega``; by default constant.
    step : float, optional
        First step along the branch, in units of the range of the parameter; 0.02 by default.
    n_orbits : int
        The most orbits.
    largest : float
        The longest step, in units of the first step.

    Returns
    -------
    Branch
        `message` gives the reason for the end of the branch, also for an early end.

    Raises
    ------
    ValueError, TypeError
        For an unknown parameter, a parameter that is no number, and an `end` at its present value.

    Notes
    -----
    Pseudo-arclength continuation with exact derivatives with respect to state, period and
    parameter (Keller 1977; Seydel, section 4.5). At a special point, one of four test functions
    changes: the direction of the parameter (fold), the product of all (multiplier + 1) (period
    doubling), the product of all (multiplier - 1) (branch point), the number of complex multipliers
    outside the unit circle (torus). Halving the step between two orbits locates the special point
    to the accuracy of the orbits.

    Examples
    --------
    >>> orbit = periodic_orbit(duffing, [0.2, 0], 2 * math.pi / 0.8, (0.8,), transient=200)
    >>> branch = continuation(orbit, "omega", 2.0, lambda omega: 2 * math.pi / omega)
    """
    path = Path.of(orbit, parameter, end, period)
    count(n_orbits, "n_orbits")
    length = first = STEP if step is None else positive(step, "step")
    here = path.begin()
    points = [here]
    special = []
    message = f"It has {n_orbits} orbits, the most."
    while len(points) < n_orbits:
        try:
            there, passes = path.next(here, length)
        except NotConvergedError as reason:
            length *= SHORTER
            if length < SHORTEST * first:
                message = f"It is lost at {path.value(here):.6g}. {reason}"
                break
            continue
        special += path.between(here, there, length)
        points.append(there)
        here = there
        value = path.value(there)
        if passes <= FAST:
            length = min(length * LONGER, largest * first)
        if (value - path.end) * path.sign >= 0.0:
            points[-1] = path.at_value(points[-2], there, path.end)
            message = f"It reaches {end:g}."
            break
        if (value - path.start) * path.sign < 0.0:
            message = f"It comes back to {path.start:g}."
            break
        if not orbit.forced and there.orbit.amplitude.max() < SMALL * orbit.amplitude.max():
            message = f"It shrinks to an equilibrium at {value:.4g}."
            break
    label = orbit.equations.parameter_label(path.j)
    values = np.array([path.value(point) for point in points])
    special = [s for s in special if (s.value - path.end) * path.sign <= 0.0]
    return Branch(label.name, label.unit, values, [p.orbit for p in points], special, message)
