"""solve_ivp with `discrete`: the problem of the longer state, and the parts of its result."""

import numpy as np

from fastdyn.problem import discrete as longer
from fastdyn.problem import validate
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.result import OdeResult


def solve_with_discrete(solve, discrete, given):
    """The result of ``solve(**given)``, with the fields `discrete` and `discrete_events`.

    `solve` is `solve_ivp`.
    """
    given = dict(given)
    y0, method = validate.initial_state(given["y0"]), given["method"]
    d0, events = longer.discrete_states(discrete, y0, given["events"], given)
    n, m = len(y0), len(d0)
    ours = None if method == "auto" else validate.method_named(method)
    if method != "auto" and (ours is None or ours.second_order):
        raise ValueError(
            f"{method!r} takes no `discrete`; RK4, Gauss8 and fastdyn's adaptive methods do."
        )
    if given["vectorized"]:
        raise ValueError("`discrete` and `vectorized` do not go together.")
    on_event = given.pop("on_event")
    for name in ("at", "every"):
        given.pop(name, None)
    given["events"], given["on_event"] = longer.extended_events(events, on_event, n, m)
    given["fun"] = longer.extended_function(given["fun"], n, m)
    given["y0"] = longer.extended_state(y0, d0)
    return _parted(solve(**longer.extended_options(given, ours, n, m)), n)


def _parted(whole, n):
    """The result with the first n components as the state, the others as discrete states."""
    result = OdeResult(whole)
    states = np.asarray(whole.y)
    if len(whole.t):
        result.y, result.discrete = states[:n], states[n:]
    else:
        result.discrete = whole.y
    result.y_events = [y[:, :n] if y.size else y for y in whole.y_events]
    result.discrete_events = [y[:, n:] if y.size else y for y in whole.y_events]
    if "sensitivity" in result:
        found = {name: each[:n] for name, each in whole.sensitivity.items()}
        if "y0" in found:
            found["y0"], found["discrete"] = np.split(found["y0"], [n], axis=1)
        result.sensitivity = found
    if whole.sol is not None:
        sol = whole.sol
        floors = None if sol.floors is None else sol.floors[:, :n]
        result.sol = PiecewisePolynomial(sol.ts, sol.polynomials[..., :n], sol.spans, floors)
    return result
