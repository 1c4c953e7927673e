"""Linearisation: the exact Jacobian, its eigenvalues, the kind of an equilibrium, its modes."""

import dataclasses
import math
import re
from typing import Any

import numpy as np

from fastdyn.plot.displayed import Displayed
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from ..equations import Derivatives, SystemEquations, equations_of, state_of
from .inputs import ports
from .kinds import kind_of, not_differentiable, vanishing

ROUNDING = 1e-13  # of the largest eigenvalue: real parts of modes below are given as 0
AT_REST = 1e-8  # of the terms of f: rates below are rounding
SEEN = 0.1  # of the largest component of a mode: those below are not named


@dataclasses.dataclass(frozen=True)
class Mode:
    """A real eigenvalue, or a pair of conjugate ones.

    Attributes
    ----------
    eigenvalue : complex
        Of a pair, the one above the real axis.
    shape : ndarray of complex, shape (n,)
        Eigenvector; its largest position, or component, is 1.
    name : str
        What the components do.
    """

    eigenvalue: complex
    shape: np.ndarray
    name: str

    @property
    def oscillates(self):
        """Whether the eigenvalue is one of a pair."""
        return self.eigenvalue.imag > 0

    @property
    def frequency(self):
        """Angular frequency, the imaginary part."""
        return self.eigenvalue.imag

    @property
    def natural_frequency(self):
        """Angular frequency without damping, the size of the eigenvalue."""
        return abs(self.eigenvalue)

    @property
    def damping_ratio(self):
        """``-Re/|eigenvalue|``: 1 for a decay without oscillation, negative for growth."""
        return 0.0 - self.eigenvalue.real / abs(self.eigenvalue) if self.eigenvalue else math.nan

    @property
    def period(self):
        """2 pi over the frequency; infinite without oscillation."""
        return 2.0 * math.pi / self.frequency if self.oscillates else math.inf

    def __str__(self):
        size = f"{self.eigenvalue.real:+.6g}" if self.eigenvalue.real else "0"
        if not self.oscillates:
            return f"{size:>12}{'':>32}  {self.name}"
        return (
            f"{size:>12} ± {self.frequency:<10.6g} i  damping ratio {self.damping_ratio:<8.4g}"
            f"  {self.name}"
        )


@dataclasses.dataclass(frozen=True, repr=False)
class Linearisation(Displayed):
    """
    Equations linearised at a state: d(y - y0)/dt = rates + A (y - y0) + B (u - u0).

    Attributes
    ----------
    t : float
    y : ndarray, shape (n,)
    rates : ndarray, shape (n,)
        f(t, y), zero at an equilibrium.
    matrix : ndarray, shape (n, n)
        The exact Jacobian df/dy; NaN where f has a kink or a jump at this state.
    eigenvalues : ndarray of complex, shape (n,)
        By decreasing real part; 0 where no more is known of a computed equilibrium, NaN where
        `matrix` has NaN.
    modes : list of Mode
        By increasing size of the eigenvalue; empty where `matrix` has NaN.
    equilibrium : bool
        Whether `rates` is zero but for rounding.
    autonomous : bool
        Whether f does not depend on t; otherwise all this holds at `t` alone.
    kind : str
        "stable node", "unstable focus", "saddle", "centre", ...; of the linear part. "not
        differentiable there" on kinks and jumps.
    stable : bool or None
        None where the linear part does not decide.
    inputs, outputs : tuple of str
        The names of inputs u and outputs v; empty where none were asked for.
    B, C, D : ndarray or None
        Of v - v0 = C (y - y0) + D (u - u0); NaN on kinks and jumps. None without inputs.
    """

    equations: SystemEquations
    t: float
    y: np.ndarray
    rates: np.ndarray
    matrix: np.ndarray
    eigenvalues: np.ndarray
    modes: list
    equilibrium: bool
    autonomous: bool
    kind: str
    stable: bool | None
    inputs: tuple = ()
    outputs: tuple = ()
    B: Any = None
    C: Any = None
    D: Any = None

    @property
    def A(self):
        """The `matrix`."""
        return self.matrix

    def _with_inputs(self):
        if self.B is None:
            raise ValueError('There are no inputs: name them, linearise(fun, y, inputs="force").')

    def transfer(self, s):
        """The transfer function C (s - A)^-1 B + D.

        Parameters
        ----------
        s : array_like of complex, shape (...)
            ``1j * omega`` for the response to sin(omega t).

        Returns
        -------
        ndarray of complex, shape (n_outputs, n_inputs, ...)
        """
        self._with_inputs()
        s = np.asarray(s, complex)
        of_all = s[..., None, None] * np.eye(len(self.y)) - self.matrix
        found = self.C @ np.linalg.solve(of_all, self.B + np.zeros((*s.shape, 1, 1))) + self.D
        return np.moveaxis(found, (-2, -1), (0, 1))

    def to_control(self) -> Any:
        """The linear system as `control.StateSpace` of python-control, with its names.

        Needs ``pip install ".[control]"``.
        """
        from fastdyn.plot.needed import needed

        self._with_inputs()
        states = [label.name for label in self.equations.labels(len(self.y))]
        given = {"inputs": list(self.inputs), "outputs": list(self.outputs), "states": states}
        state_space = needed("control", "`to_control` needs python-control").ss
        return state_space(self.matrix, self.B, self.C, self.D, **_plain(given))

    @property
    def title(self):
        """The kind, named as that of the linear part where this does not decide."""
        undecided = self.kind in ("centre", "stable directions and undamped oscillations")
        return f"{self.kind} of the linear part" if undecided else self.kind

    def __str__(self):
        named = zip(self.equations.labels(len(self.y)), self.y, strict=True)
        place = ", ".join(f"{label.name} = {round(value, 12) + 0.0:.6g}" for label, value in named)
        head = f"{self.title} at {place}"
        return "\n".join([head, *(f"  {mode}" for mode in self.modes)])

    def plot(self, **options) -> Any:
        """Draw the eigenvalues in the complex plane, and the shapes of the modes.

        `options` are those of ``matplotlib.pyplot.figure``; returns a Figure.
        """
        from fastdyn.plot.analysis.linear import figure

        return figure(self, **options)


@shown_when_wrong(t=kinds.number)
def linearise(fun, y=None, args=(), t=0.0, inputs=None, outputs=None):
    """Linearise equations at a state.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    y : array_like, shape (n,), optional
        State; of a system, its initial state by default.
    args : tuple
        Arguments of a function.
    t : float
        Time, for equations that depend on the time.
    inputs : str, int, or list of these, optional
        Arguments of the equations, by name or position, that are inputs: numbers, and arrays of
        shape (m,).
    outputs : str, int, list of these, callable, or dict of callable, optional
        Components of the state, by name or number; or ``outputs(t, y, *args)``, one number or
        several; or such functions by name. By default all components.

    Returns
    -------
    Linearisation

    Raises
    ------
    ValueError
        For a function that cannot be traced or differentiated, and for a state at which `fun` or
        its Jacobian is not finite.

    Notes
    -----
    The derivatives are those of the traced function, exact but for rounding; differences to both
    sides tell whether the function has a derivative at the state. Kinds of equilibria and of modes:
    Strogatz, Nonlinear Dynamics and Chaos, chapters 5 and 6.

    Examples
    --------
    >>> from fastdyn import systems
    >>> [mode.frequency for mode in linearise(systems.building()).modes]  # 8.740, 22.882 rad/s
    """
    equations = equations_of(fun, args)
    y = state_of(equations, y, "y")
    t = float(t)
    found = linearised(equations, equations.differentiated(t, y), t, y)
    if inputs is None:
        if outputs is not None:
            raise ValueError("`outputs` are those of `inputs`: name arguments of `fun`.")
        return found
    return dataclasses.replace(found, **ports(equations, t, y, inputs, outputs)._asdict())


def _plain(names):
    """Names for python-control, which takes no brackets, dots and commas."""
    return {
        kind: [re.sub(r"[^\w ]+", "_", n).strip("_") for n in each] for kind, each in names.items()
    }


def linearised(equations, derivatives: Derivatives, t, y):
    """The Linearisation at a state, with derivatives that are compiled."""
    rates = equations.rates(t, y)
    matrix = derivatives.at(t, y)
    for about, numbers in (("`fun`", rates), ("The Jacobian of `fun`", matrix)):
        if not np.isfinite(numbers).all():
            raise ValueError(f"{about} is not finite at t = {t:g}, y = {y}.")
    equilibrium = at_rest(rates, matrix, y)
    broken = not_differentiable(equations, derivatives, t, y, matrix)
    jumps = bool(broken.any())
    if jumps:
        matrix = np.where(broken, np.nan, matrix)
        kind = "not differentiable there"
        stable = None
        values = np.full(len(y), np.nan, complex)
        modes = []
    else:
        values, vectors = np.linalg.eig(matrix.astype(complex))
        order = np.lexsort((-np.imag(values), -np.real(values)))
        values = values[order]
        vectors = vectors[:, order]
        if equilibrium:
            values[vanishing(derivatives, t, y, rates, matrix, values)] = 0.0
        kind, stable = kind_of(values)
        modes = modes_of(equations, matrix, values, vectors)
    if not equilibrium:
        kind = f"no equilibrium, {kind}" if jumps else "no equilibrium"
        stable = None
    return Linearisation(
        equations, t, y, rates, matrix, values, modes, equilibrium, derivatives.autonomous, kind,
        stable,
    )  # fmt: skip


def at_rest(rates, matrix, y):
    """Whether rates are zero but for the rounding of their terms."""
    terms = np.abs(matrix) @ np.maximum(np.abs(y), 1e-3 * max(1.0, np.abs(y).max()))
    return bool((np.abs(rates) <= AT_REST * terms.max()).all()) or not rates.any()


def modes_of(equations, matrix, values, vectors):
    """The Modes, by increasing size of the eigenvalue."""
    labels = equations.labels(len(values))
    n = len(values)
    half = n // 2
    ahead = np.hstack([np.zeros((half, half)), np.eye(half)])
    places = half if n == 2 * half and np.array_equal(matrix[:half], ahead) else n
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag < 0:
            continue
        if abs(value.real) <= ROUNDING * np.abs(values).max():
            value = complex(0.0, value.imag)
        at = int(np.argmax(np.abs(vector[:places])))
        if np.abs(vector[at]) > 0:
            vector = vector / vector[at]
        names = [label.name for label in labels[:places]]
        found.append(Mode(complex(value), vector, _named(value, vector[:places], names)))
    return sorted(found, key=lambda mode: (abs(mode.eigenvalue), -mode.eigenvalue.real))


def _named(value, shape, names):
    """The motion of the components in a mode, in words."""
    if value.imag > 0:
        what = "oscillation"
    else:
        what = "growth" if value.real > 0 else "decay" if value.real < 0 else "rest"
    seen = np.flatnonzero(np.abs(shape) >= SEEN * np.abs(shape).max())
    if len(seen) > 4:
        return f"{what} of {len(seen)} components"
    said = " and ".join([", ".join(names[i] for i in seen[:-1]), names[seen[-1]]]).removeprefix(
        " and "
    )
    if len(seen) < 2:
        return f"{what} of {said}"
    phases = np.angle(shape[seen] / shape[seen[0]])
    if np.all(np.abs(phases) < 0.3):
        return f"{what} of {said} together"
    if len(seen) == 2 and abs(phases[1]) > math.pi - 0.3:
        return f"{what} of {said} against each other"
    return f"{what} of {said}"
