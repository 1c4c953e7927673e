"""MATLAB's dde23 and ddesd, on `solve_dde`."""

from typing import Any

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.delays import solve_dde
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong, takes

from .options import check_options, chosen, odeset
from .others import numbers_or_function
from .solution import AtTimes, Refined, Request, Solution
from .solve import PARAMETERS, Solver, times_of

FOR_LAGS = Solver("dde23", "Tsit5")
FOR_DELAYS = Solver("ddesd", "Tsit5")


@shown_when_wrong(PARAMETERS, lags=kinds.numbers)
def dde23(ddefun, lags, history, tspan, options=None) -> Solution:
    """
    Solve y' = f(t, y, Z) with constant delays, as MATLAB's dde23.

    Solved by `solve_dde` with Tsit5, of order 5 where MATLAB's pair has order 3.  Of the options
    RelTol, AbsTol, MaxStep and InitialStep have an effect.

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

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        If a delay is not positive.
    """
    lags = np.ravel(np.asarray(lags, float))
    if not (lags > 0.0).all():
        raise ValueError(f"`lags` must be positive; got {lags}.")
    listed = lags.tolist()

    def fun(t, y, past):
        return ddefun(t, y, np.stack([past(t - lag) for lag in listed], axis=-1))

    takes("ddefun", ddefun, "t, y, Z", PARAMETERS)
    return _solved(FOR_LAGS, fun, history, tspan, options, lags)


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

    def fun(t, y, past):
        times = np.ravel(times_at(t, y))
        return ddefun(t, y, np.stack([past(time) for time in times], axis=-1))

    takes("ddefun", ddefun, "t, y, Z", PARAMETERS)
    return _solved(FOR_DELAYS, fun, history, tspan, options, [])


def _solved(solver, fun, history, tspan, options, lags):
    check_options(options)
    given = odeset(options or {})
    times = times_of(tspan)
    known = history.result if isinstance(history, Solution) else history
    result: Any = solve_dde(
        fun,
        (times[0], times[-1]),
        known,
        "Tsit5",
        dense_output=True,
        delays=lags,
        **chosen(given),
    )
    if not result.success:
        warn(f"Failure in {solver.name}: {result.message}")
    output = Refined(given.Refine or 1) if len(times) == 2 else AtTimes(times, False)
    return Solution(Request(solver, fun, given), result, output, None)
