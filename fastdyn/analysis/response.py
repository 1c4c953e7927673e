"""Frequency response: the steady state over the frequency, swept up and down.

The steady state of linear equations is computed exactly, from the harmonics of the forcing.
"""

import collections
import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import NotConvergedError, SystemEquations, count, equations_of, state_of
from .flow import METHOD, Flow, options_of
from .orbit import POINTS, found_orbit, half_ranges
from .period import check_period, looks
from .rest.kinds import ZERO

AGAIN = 5  # factor by which a transient that was too short is prolonged
ADVICE = "The period is 2 pi / frequency: is `parameter` the angular frequency of the forcing?"
REFERENCES = {"cos": 0.0, "sin": 0.5 * math.pi}
LINEAR = 1e-12  # relative change of the Jacobian of linear equations
LOOKS = 5  # times and states at which the Jacobian is compared
SAMPLES = (256, 1024, 4096)  # samples of the forcing in a period, increased in turn
SMOOTH = 1e-6  # relative change of the amplitude by more samples
RESONANT = 1e-12  # relative distance of an eigenvalue from a frequency that counts as resonance
UNSTABLE = "the equations have motions that grow"
ROUGH = "The forcing has jumps or kinks: amplitudes are not exact, but to some 1e-3."
UNDAMPED = "resonance without damping"
LEAST = 1e-13  # harmonic of the forcing, relative to the largest


class Sweep(NamedTuple):
    """The steady states of one sweep; NaN if no steady state was found.

    `amplitude` is half the range of each component.  `harmonic` is the complex amplitude of the
    component at the frequency of the forcing.  Both have shape (n, n_frequencies).
    """

    amplitude: np.ndarray
    harmonic: np.ndarray

    @property
    def phase(self):
        """The phase lead of `harmonic` over the reference, rad."""
        return np.angle(self.harmonic)


@dataclasses.dataclass(frozen=True, repr=False)
class Response(Displayed):
    """
    A frequency response.

    Attributes
    ----------
    frequencies : ndarray, shape (n_frequencies,)
        Angular frequencies, increasing.
    linear : bool
        Whether the equations are linear; a formula then gives the response.
    sweeps : dict of str to Sweep
        "exact" for linear equations, otherwise "up" and "down".
    message : str
        The frequencies without a steady state, and the reasons.
    """

    equations: SystemEquations
    frequencies: np.ndarray
    linear: bool
    reference: str
    sweeps: dict[str, Sweep]
    message: str

    @property
    def amplitude(self):
        """Amplitudes of the first sweep, shape (n, n_frequencies)."""
        return next(iter(self.sweeps.values())).amplitude

    @property
    def phase(self):
        """Phases of the first sweep."""
        return next(iter(self.sweeps.values())).phase

    def jumps(self, component=0):
        """Frequencies at which a sweep jumps: name of the sweep to array.

        A jump is a change of the amplitude of the component between two neighbours by more than a
        tenth of the largest amplitude, where the other sweep does not change as much.
        """
        if self.linear:
            return {}
        changes = {
            name: np.abs(np.diff(sweep.amplitude[component])) for name, sweep in self.sweeps.items()
        }
        known = [s.amplitude[component] for s in self.sweeps.values()]
        most = 0.1 * np.nan_to_num(known).max()
        found = {}
        for name, change in changes.items():
            other = next(iter(changes[k] for k in changes if k != name), np.zeros_like(change))
            at = np.flatnonzero((change > most) & ~(other > most))
            found[name] = self.frequencies[at + (name == "up")]
        return found

    def __str__(self):
        how = "linear equations, exact" if self.linear else f"sweeps {', '.join(self.sweeps)}"
        return f"Response at {len(self.frequencies)} frequencies, {how}. {self.message}".strip()

    @filled()
    def plot(self, components=None, **options) -> Any:
        """Draw amplitude and phase over the frequency.

        Parameters
        ----------
        components : name, int or sequence of them, optional
            By default the first half of the state, which mostly has the positions.
        {figure}
        """
        from fastdyn.plot.analysis.orbits import response

        return response(self, components, **options)


@filled()
@shown_when_wrong(frequencies=kinds.numbers, transient=kinds.number, method=kinds.method)
def frequency_response(
    fun, frequencies, parameter="omega", args=(), y0=None, sweep="both", transient=50,
    reference="cos", method=METHOD, **options,
):  # fmt: skip
    """The steady state of equations that are forced periodically, over the frequency.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, of period 2 pi / frequency in t, or a system.
    frequencies : array_like, shape (n_frequencies,)
        Positive angular frequencies, increasing.
    parameter : str or int
        Name of the argument that is the frequency, or its position among the arguments.
    args : tuple
        Arguments of a function; the sweep replaces the value of the frequency.
    y0 : array_like, shape (n,), optional
        State at which a sweep begins; of a system, its initial state by default.
    sweep : {"both", "up", "down"}
        Sweeps of nonlinear equations.  Each frequency begins with the steady state of the frequency
        before.
    transient : int
        Periods that are solved at each frequency before the search for the periodic orbit.
    reference : {"cos", "sin"}
        The reference of phases: cos(omega t) or sin(omega t).
    method, **options
        As in `solve_ivp`; by default DOP853, rtol = {rtol of frequency_response}, atol =
        {atol of frequency_response}.

    Returns
    -------
    Response
        With NaN at frequencies without a stable steady state of the period of the forcing;
        unstable linear equations have NaN everywhere.  `message` gives the reasons.

    Raises
    ------
    ValueError
        For equations that do not depend on the time, or have another period, and for functions
        that cannot be traced or differentiated.

    Notes
    -----
    If the Jacobian is equal at several states and times, the equations count as linear, and the
    response to a harmonic g of the forcing is (i omega - J)^-1 g. Otherwise shooting follows the
    transient, and unstable orbits are dropped. At the end of a stable branch, the sweep therefore
    jumps, as in an experiment; `continuation` follows the unstable branch.

    Examples
    --------
    >>> import math
    >>> def duffing(t, y, omega):
    ...     return [y[1], -0.1 * y[1] - y[0] - y[0]**3 + 0.3 * math.cos(omega * t)]
    >>> frequency_response(duffing, np.linspace(0.5, 2.5, 101), args=(1.0,), y0=[0, 0]).plot()
    """
    equations = equations_of(fun, args)
    omegas = _checked(frequencies)
    options = options_of(frequency_response, method, options)
    if sweep not in ("both", "up", "down"):
        raise ValueError(f"`sweep` must be both, up or down; got {sweep!r}.")
    if reference not in [*REFERENCES]:
        raise ValueError(f"`reference` must be cos or sin; got {reference!r}.")
    transient = count(transient, "transient", 0)
    y = state_of(equations, y0)
    j = equations.parameter(parameter)
    equations.number(j)
    for omega in (omegas[0], omegas[-1]):
        here = equations.replaced(j, omega)
        if here.differentiated(0.0, y).autonomous:
            raise ValueError("`fun` does not depend on the time: nothing forces it.")
        check_period(here, 0.0, y, 2.0 * math.pi / omega, ADVICE)
    turn = np.exp(1j * REFERENCES[reference])
    if all(is_linear(equations.replaced(j, omega), y, omega) for omega in (omegas[0], omegas[-1])):
        found = [exact(equations.replaced(j, omega), y, omega) for omega in omegas]
        sweeps = {"exact": _joined([steady for steady, _ in found], turn, len(y))}
        message = _missing([reason for steady, reason in found if steady is None])
        rough = {reason for steady, reason in found if steady is not None and reason}
        message = " ".join([message, *rough]).strip()
    else:
        sweeps = {}
        missing = []
        for name in ("up", "down") if sweep == "both" else (sweep,):
            order = slice(None) if name == "up" else slice(None, None, -1)
            found = []
            state = y
            for omega in omegas[order]:
                flow = Flow(equations.replaced(j, omega), options)
                steady, state = _steady(flow, state, 2.0 * math.pi / omega, transient)
                found.append(steady)
            sweeps[name] = _joined(found[order], turn, len(y))
            missing += [f"sweep {name}" for steady in found if steady is None]
        message = _missing(missing)
    return Response(equations, omegas, "exact" in sweeps, reference, sweeps, message)


def _checked(frequencies):
    omegas = np.atleast_1d(np.asarray(frequencies, float))
    if omegas.ndim != 1 or not omegas.size or not np.isfinite(omegas).all():
        raise ValueError("`frequencies` must be a finite 1-D array.")
    if not (omegas > 0.0).all() or (np.diff(omegas) <= 0.0).any():
        raise ValueError("`frequencies` must be positive and increasing.")
    return omegas


def _steady(flow, state, period, transient):
    """((amplitude, harmonic) or None, the state with which the next frequency begins)."""
    for periods in (transient, AGAIN * max(transient, 1)):
        try:
            if periods:
                state = flow.curve(state, 0.0, periods * period, 2)[1][:, -1]
            orbit = found_orbit(flow, state, period, 0.0, True)
        except NotConvergedError:
            continue
        far = np.abs(orbit.y0 - state).max() > 0.1 * np.ptp(orbit.y, axis=1).max()
        if orbit.stable and not far:
            parts = np.fft.fft(orbit.y[:, :-1])[:, 1] * 2.0 / (POINTS - 1)
            return (orbit.amplitude, parts), orbit.y0
    return None, state


def _missing(reasons):
    """The number of frequencies without a steady state, and the reasons, in a sentence."""
    counts = collections.Counter(reasons)
    if not counts:
        return ""
    told = "; ".join(f"{number}: {reason}" for reason, number in counts.items())
    return f"{counts.total()} steady states were not found ({told})."


def _joined(found, turn, n):
    """The Sweep of n components from what was found at each frequency."""
    nothing = np.full(n, np.nan)
    both = [one or (nothing, nothing) for one in found]
    return Sweep(np.array([a for a, _ in both]).T, np.array([h for _, h in both]).T * turn)


def is_linear(equations, y, omega):
    """Whether the Jacobian is equal at several states and times."""
    derivatives = equations.differentiated(0.0, y)
    period = 2.0 * math.pi / omega
    first, *others = [derivatives.at(t, state) for t, state in looks(0.0, y, period)[:LOOKS]]
    size = np.abs(first).max()
    return all(np.abs(each - first).max() <= LINEAR * size for each in others)


def exact(equations, y, omega):
    """((amplitude, harmonic) of linear equations, each of shape (n,), or None; a message).

    None: free motions grow and leave the steady state, or a resonance without damping has no steady
    state.
    """
    matrix = equations.differentiated(0.0, y).at(0.0, y)
    period = 2.0 * math.pi / omega
    values = np.linalg.eigvals(matrix)
    if values.real.max() > ZERO * np.abs(values).max():
        return None, UNSTABLE
    found = last = None
    change = np.inf
    for n_samples in SAMPLES:
        times = np.arange(n_samples) / n_samples * period
        forcing = np.array([equations.rates(t, y) for t in times]).T - (matrix @ y)[:, None]
        parts = np.fft.rfft(forcing) / n_samples
        kept = np.abs(parts).max(axis=0) > LEAST * np.abs(parts).max()
        kept[0] = False
        steady = np.zeros(parts.shape, complex)
        for k in np.flatnonzero(kept):
            if np.abs(1j * k * omega - values).min() <= RESONANT * k * omega:
                return None, UNDAMPED
            system = 1j * k * omega * np.eye(len(y)) - matrix
            steady[:, k] = np.linalg.solve(system, parts[:, k])
        curve = np.fft.irfft(steady * n_samples, axis=1)
        found = half_ranges(np.hstack([curve, curve[:, :1]])), 2.0 * steady[:, 1]
        if not kept[n_samples // 4 :].any():
            return found, ""
        if last is not None:
            change = np.abs(found[0] - last).max() / max(found[0].max(), 1e-300)
        last = found[0]
    return found, "" if change < SMOOTH else ROUGH
