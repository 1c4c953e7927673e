"""method="auto": Taylor where Taylor pays, else a pair by tolerance; Radau for stiff problems."""

import numpy as np

from fastdyn.problem.domains import options as domains
from fastdyn.problem.options.table import refused_among, value_of
from fastdyn.run.stiffness import Stiff, given_up
from fastdyn.specialise.series import NoSeries

LOOSE, TIGHT = 1e-5, 1e-9  # rtol above which Tsit5 is faster than Taylor, and Vern7 than Vern9


def solve_automatically(solve, given):
    """Solve by the method that suits the problem.

    If stability limits the steps, which is checked every 0.05 s, the run begins anew by Radau, or
    by SciPy's BDF for a complex state whose `fun` is left to SciPy.

    Parameters
    ----------
    solve : callable
        `solve_ivp`.
    given : dict
        The arguments of `solve_ivp` without the method.

    Returns
    -------
    OdeResult
        With the additional fields `method`, the name of the method, and `reason`, a sentence.
    """
    complex_state = np.iscomplexobj(given["y0"])
    if refused_among(given, "again"):
        return _explicit(solve, given, complex_state)
    try:
        with given_up():
            return _explicit(solve, given, complex_state)
    except Stiff as found:
        return _named(solve(method=found.method, **given), found.method, str(found))


def _explicit(solve, given, complex_state):
    """Solve by Taylor or by a pair."""
    rtol = float(np.min(value_of(given, "rtol")))
    if rtol > LOOSE:
        return _named(solve(method="Tsit5", **given), "Tsit5", f"rtol is above {LOOSE:g}.")
    name = "Vern7" if rtol > TIGHT else "Vern9"
    if complex_state:
        return _named(solve(method=name, **given), name, "The state is complex.")
    if domains.asked(given):
        reason = "A series does not end at the border of a domain."
        return _named(solve(method=name, **given), name, reason)
    try:
        result = solve(method="Taylor", **given)
    except NoSeries as refusal:
        reason = f"{refusal} rtol is {rtol:.1e}."
        return _named(solve(method=name, **given), name, reason)
    if result.status == -1:
        other = solve(method=name, **given)
        if other.status >= 0:
            return _named(other, name, f"Taylor failed: {result.message}")
    return _named(result, "Taylor", f"`fun` has a Taylor series, and rtol is at most {LOOSE:g}.")


def _named(result, method, reason):
    result.method, result.reason = method, reason
    return result
