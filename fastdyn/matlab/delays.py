"""MATLAB's dde23 and ddesd, on `solve_dde`."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.delays import solve_dde
from fastdyn.delays.history import History
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong, takes

from .events import event_functions, let_pass, occurrences
from .options import chosen
from .others import numbers_or_function
from .solution import AtTimes, Refined, Request, Solution
from .solve import PARAMETERS, Solver, options_of, print_statistics, times_of

FOR_LAGS = Solver("dde23", "Tsit5")
FOR_DELAYS = Solver("ddesd", "Tsit5")
OF_DELAYS = ("Events", "InitialY", "Jumps")


@shown_when_wrong(PARAMETERS, lags=kinds.numbers)
def dde23(ddefun, lags, history, tspan, options=None) -> Solution:
    """
    Solve y' = f(t, y, Z) with constant delays, as MATLAB's dde23.

    Solved by `solve_dde` with Tsit5, of order 5 where MATLAB's pair has order 3.

    Parameters
    ----------
    ddefun : callable
        ``ddefun(t, y, Z)`` returns n numbers; column j of Z, shape (n, k), is y(t - lags[j]).
    lags : array_like, shape (k,)
        Positive delays.
    history : array_like, callable or Solution
        The state up to the start: n numbers, a function of t, or an earlier solution.
    tspan : array_like
        As in `ode45`.
    options : Options or dict, optional
        RelTol, AbsTol, MaxStep, InitialStep, Refine and Stats as in `ode45`; Events, called as
        ``events(t, y, Z)``; InitialY, the state at the start where `history` has another there;
        Jumps, times at which `history` or `ddefun` jump.  Others that would change the solution are
        refused.

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        If a delay is not positive, or an option has no effect.
    """
    lags = np.ravel(np.asarray(lags, float))
    if not (lags > 0.0).all():
        raise ValueError(f"`lags` must be positive; got {lags}.")
    listed = lags.tolist()

    def lagged(t, y, past):
        return _columns([past(t - lag) for lag in listed], y)

    return _solved(FOR_LAGS, ddefun, lagged, history, tspan, options, lags)


@shown_when_wrong(PARAMETERS, delays=numbers_or_function)
def ddesd(ddefun, delays, history, tspan, options=None) -> Solution:
    """
    Solve y' = f(t, y, Z) with delays of the time and the state, as MATLAB's ddesd.

    Parameters
    ----------
    ddefun : callable
        As of `dde23`; column j of Z is y at the time ``delays(t, y)[j]``.
    delays : callable or array_like
        ``delays(t, y)`` returns k times, earlier than t; numbers are constant delays, as `lags`.
    history, tspan, options
        As of `dde23`.

    Returns
    -------
    Solution
    """
    if not callable(delays):
        return dde23(ddefun, delays, history, tspan, options)
    takes("delays", delays, "t, y", PARAMETERS)
    times_at: Any = delays

    def lagged(t, y, past):
        return _columns([past(time) for time in np.ravel(times_at(t, y))], y)

    return _solved(FOR_DELAYS, ddefun, lagged, history, tspan, options, [])


def _columns(states, y):
    """Past states as the columns of Z."""
    return np.stack(states, axis=-1) if states else np.empty((len(y), 0))


class Begun(NamedTuple):
    """A history with another state at its end, in the form of an earlier result."""

    before: Any
    y0: np.ndarray
    t0: float
    t_min = -np.inf

    @property
    def sol(self):
        """The state as a function of the time."""
        return self

    @property
    def jumps(self):
        """The times at which the history jumps."""
        return self.before.jumps

    def __call__(self, t) -> Any:
        return self.y0 if t >= self.t0 else self.before.before(t)


def _begun(given, before, y0):
    """The history `given`, which is `before`, with the state `y0` at its end."""
    if len(y0) != before.n:
        raise ValueError(f"InitialY has {len(y0)} numbers, and `history` {before.n}.")
    if callable(given):  # which may jump elsewhere, too
        return lambda t: y0 if t >= before.t0 else given(t)
    return Begun(before, y0, before.t0)


def _solved(solver, ddefun, lagged, history, tspan, options, lags):
    takes("ddefun", ddefun, "t, y, Z", PARAMETERS)
    given = options_of(solver.name, options, OF_DELAYS)
    times = times_of(tspan)
    span = float(times[0]), float(times[-1])
    known = history.result if isinstance(history, Solution) else history
    if not callable(known) and not hasattr(known, "sol"):
        known = np.ravel(known)
    before = History(known, *span)
    if "InitialY" in given:
        known = _begun(known, before, np.ravel(np.asarray(given["InitialY"], float)))
        before = History(known, *span)

    def fun(t, y, past):
        return ddefun(t, y, lagged(t, y, past))

    functions = None
    if "Events" in given:
        takes("Events", given["Events"], "t, y, Z")

        def events(t, y, past=before.before):
            return given["Events"](t, y, lagged(t, y, past))

        functions = event_functions(events, span[0], before.y0)
    while True:
        result: Any = solve_dde(
            fun, span, known, "Tsit5", dense_output=True, events=functions, delays=lags,
            jumps=given.get("Jumps"), **chosen(given),
        )  # fmt: skip
        if functions is None or not let_pass(functions, result):
            break
    if result.status == -1:
        warn(f"Failure in {solver.name}: {result.message}")
    print_statistics(given, result)
    found = None
    if functions is not None:
        found = occurrences(result, lambda t, y: events(t, y, result.sol))
    ended = result.status == 1
    output = Refined(given.get("Refine", 1)) if len(times) == 2 else AtTimes(times, ended)
    return Solution(Request(solver, fun, given), result, output, found)
