"""A solve along switches: the longer state of a `switches.Hybrid`, and its events."""

import numpy as np

from fastdyn.compile.derivatives.switched import ADDED, parts

from .discrete import extended_options
from .events import event_list, of_own
from .options.table import TOLERANCES, value_of

TAKEN = {"rtol", "atol", "max_step", "first_step", "max_steps"}
# Width of a switch, in tolerances: see `hybrid`.  With 1, a relay takes 20 000 steps instead of 30,
# because steps that touch the other side end on this side; grazing contact is seen up to WIDTH.
WIDTH = 30.0
# Tolerance of the integrals of shares, over rtol, and the least one.  The solution may leave a
# switch and return within a step: with 1 instead of 1e-4, 3 of 150 random problems have errors of
# 1e-3 at rtol = 1e-6, with 1e-4 none of 300.
SMOOTH, LEAST = 1e-4, 1e-13


def longer(asked, of, chosen):
    """The Arguments of the longer state; None if an option does not go together with modes."""
    a, n = asked, len(asked.y0)
    given = {name for name, value in a.options.items() if value is not None}
    if not given <= TAKEN or a.vectorized or a.sensitivity is not None or a.error_estimate:
        return None
    rtol, atol = (np.ravel(value_of(a.options, name)).astype(float) for name in TOLERANCES)
    size, atol = np.abs(a.y0).max(), atol[atol > 0.0]
    least = atol.min() if atol.size else rtol.min() * (size or 1.0)
    distance = least + rtol.min() * size
    widths = WIDTH * least, WIDTH * rtol.min(), distance
    modes, fun, events, jumps = parts(of, chosen, widths, a.t0, a.y0)
    own = [of_own(event, n) for event in event_list(a.events) or ()]
    m, span = len(modes), abs(a.tf - a.t0)
    options = extended_options(dict(a.options), None, n, ADDED * m)
    options["atol"][n + m : n + 2 * m] = distance
    options["rtol"] = np.resize(options["rtol"], n + ADDED * m)
    options["rtol"][n + 2 * m :] = LEAST + SMOOTH * rtol.min()
    options["atol"][n + 2 * m :] = SMOOTH * rtol.min() * (span if np.isfinite(span) else 1.0)
    options["on_event"] = [None] * len(own) + jumps
    state = np.r_[a.y0, modes, np.zeros((ADDED - 1) * m)]
    return a._replace(fun=fun, y0=state, given_y0=state, events=[*own, *events], options=options)
