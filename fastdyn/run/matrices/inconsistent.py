"""The sentences about states that do not fulfil the algebraic equations of a mass matrix."""

import numpy as np

NOT_OF_INDEX_1 = (
    "With this `mass` the equations are no DAE of index 1 at the start: the algebraic ones do not "
    "determine the algebraic variables. Differentiate the constraints by hand until they do, or "
    "leave out what is said twice; `solve_dae` does that by itself."
)
SHARE, SHOWN = 0.3, 5  # least number shown, as a share of the largest; most names in a message


class Inconsistent(ValueError):
    """A start, or the state behind an action, that violates the algebraic equations."""


def refuse_start(mass, t, y):
    """Raise the ValueError of a start that is not consistent; `mass` is a `mass.Mass`."""
    p = mass.problem
    change = mass.called("change", t, y)
    if np.isnan(change).any():
        raise Inconsistent(NOT_OF_INDEX_1)
    far = np.abs(change) / (p.atol + p.rtol * np.abs(y))
    raise Inconsistent(
        f"`y0` does not fulfil the algebraic equations, the rows where `mass` is singular: "
        f"component {np.argmax(far)} is off by {far.max():.2g} times its tolerance. "
        + _advice(mass, t, y)
    )


def _advice(mass, t, y):
    found = mass.called("settle", t, y)
    if not np.isfinite(found).all() or len(_unfulfilled(mass, t, found)):
        return "Newton's iteration finds no state near it that does: start nearer to one."
    return f"Start from {found.tolist()}, where they hold."


def refuse_action(mass, t, y):
    """Raise the ValueError of a state y behind an action that cannot be made consistent."""
    found = _unfulfilled(mass, t, mass.called("settle", t, y))
    said = "the algebraic equations do not determine the algebraic components there"
    if len(found):
        more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
        several = len(found) > 1
        said = (
            f"equation{'s' if several else ''} {', '.join(map(str, found[:SHOWN]))}{more} of `fun` "
            f"{'stay' if several else 'stays'} different from 0"
        )
    raise Inconsistent(
        f"At t = {t:.10g} no consistent state is found behind an action of `on_event`, or behind a "
        f"breakpoint: with M y held, {said}. Let `on_event` return a state for which the algebraic "
        "equations, the rows where `mass` is singular, have a solution, and start Newton's "
        "iteration near it."
    )


def _unfulfilled(mass, t, y):
    """The equations of the combinations that are not 0 at the end of Newton's iteration."""
    f = mass.fun(t, y)
    change = mass.called("change", t, y)
    if not np.isfinite(f).all():
        return np.flatnonzero(~np.isfinite(f))
    p = mass.problem
    if np.all(np.abs(change) <= p.atol + p.rtol * np.abs(y)):
        return np.empty(0, int)
    off = np.abs(mass.left @ f)
    wrong = np.abs(mass.left[off > 1e-3 * off.max(initial=0.0)])
    return np.flatnonzero((wrong >= SHARE * wrong.max(axis=1, keepdims=True, initial=0.0)).any(0))
