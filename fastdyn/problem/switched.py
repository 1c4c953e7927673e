"""A solve along switches: the longer state of a `switches.Hybrid`, and its events."""

import numpy as np

from fastdyn.compile.derivatives.switched import ADDED, behind_jumps, leaves, parts

from .discrete import extended_options
from .events import event_list, of_own
from .options.table import TOLERANCES, value_of
from .schedules import at

TAKEN = {"rtol", "atol", "max_step", "first_step", "max_steps"}
# Width of a switch, in tolerances: see `hybrid`.  With 1, a relay takes 20 000 steps instead of 30,
# because steps that touch the other side end on this side; grazing contact is seen up to WIDTH.
WIDTH = 30.0
# Tolerance of the integrals of shares, over rtol, and the least one.  The solution may leave a
# switch and return within a step: with 1 instead of 1e-4, 3 of 150 random problems have errors of
# 1e-3 at rtol = 1e-6, with 1e-4 none of 300.
SMOOTH = 1e-4
LEAST = 1e-13
BESIDE = 1e-9  # distance from switching times, relative, within which no state is looked at
MOST_LOOKED_AT = 64  # states of a solution along switches: a look takes some 50 us


def widths_of(asked):
    """The widths of the switches of Arguments, as `hybrid` takes them."""
    rtol, atol = (np.ravel(value_of(asked.options, name)).astype(float) for name in TOLERANCES)
    size = np.abs(asked.y0).max()
    atol = atol[atol > 0.0]
    least = atol.min() if atol.size else rtol.min() * (size or 1.0)
    return WIDTH * least, WIDTH * rtol.min(), least + rtol.min() * size


def slid_away(asked, of, chosen, t, z):
    """Whether a solution along switches is far from one of them, of some of its longer states."""
    widths = widths_of(asked)
    times = of.times(asked.t0, asked.tf)
    if len(times):  # at a switching time itself, the mode is that before
        apart = np.abs(np.subtract.outer(t, times)).min(axis=1) > BESIDE * np.abs(times).max()
        t = t[apart]
        z = z[:, apart]
    looked_at = np.unique(np.linspace(0, len(t) - 1, MOST_LOOKED_AT).astype(int)) if len(t) else ()
    return any(leaves(of, chosen, widths, float(t[i]), z[:, i]) for i in looked_at)


def longer(asked, of, chosen):
    """The Arguments of the longer state; None if an option does not go together with modes."""
    a = asked
    n = len(asked.y0)
    given = {name for name, value in a.options.items() if value is not None}
    if not given <= TAKEN or a.vectorized or a.sensitivity is not None or a.error_estimate:
        return None
    rtol = np.ravel(value_of(a.options, "rtol")).astype(float)
    widths = widths_of(a)
    distance = widths[2]
    modes, fun, events, jumps = parts(of, chosen, widths, a.t0, a.y0)
    own = [of_own(event, n) for event in event_list(a.events) or ()]
    m = len(modes)
    span = abs(a.tf - a.t0)
    options = extended_options(dict(a.options), None, n, ADDED * m)
    options["atol"][n + m : n + 2 * m] = distance
    options["rtol"] = np.resize(options["rtol"], n + ADDED * m)
    options["rtol"][n + 2 * m :] = LEAST + SMOOTH * rtol.min()
    options["atol"][n + 2 * m :] = SMOOTH * rtol.min() * (span if np.isfinite(span) else 1.0)
    own_actions = [None] * len(own)
    behind = []
    acts = []
    times = of.times(a.t0, a.tf)
    if len(times):
        behind = [at(times)]
        acts = [behind_jumps(of, chosen, widths, times, a.tf)]
    options["on_event"] = own_actions + jumps + acts
    state = np.r_[a.y0, modes, np.zeros((ADDED - 1) * m)]
    # Their divisors are rounding where the state slides.
    slow = [event.changed(turns=False) for event in event_list(events)]
    return a._replace(
        fun=fun, y0=state, given_y0=state, events=[*own, *slow, *behind], options=options
    )
