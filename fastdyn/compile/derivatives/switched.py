"""Compiles the motion along switches: a function whose jumps are followed by modes.

See `fastdyn/trace/graph/switches.py`.
"""

from typing import Any

import numpy as np

from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.jumps import decisions
from fastdyn.trace.graph.refusal import Refusal, Untraceable
from fastdyn.trace.graph.signs import forced, with_signs
from fastdyn.trace.graph.switches import LARGEST, MOST, hybrid, switches
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.reads.reads import flat

from ..functions import with_code
from ..mode import DERIVATIVE
from ..python_callback import Held
from ..python_callback import evaluate as in_python
from ..traced.known import Attempt
from ..traced.make import made

# Conditions, up to which the steps of Taylor end at each.  With those of a limiter on a grid of 40,
# which are all undecided where the grid is at rest, Taylor fails after 0.2 s; Tsit5 takes 0.2 ms.
FEW = 16
ROUNDING = 1e-12  # share of the two sides of a comparison that counts as no distance
EVENTS, ADDED = 3, 3  # of a switch: events, and numbers behind the state
NEWTON, JUMP = 3, 1e-8  # Newton's steps to a switch; the smallest jump, relative
BEHIND = 1e-14  # how far behind a jump in time the differences are looked at, relative
FAR = 100.0  # widths of a switch, from which on a solution does not slide along the switch
STEPS = 10.0  # distance from a switch, in steps, up to which a solution slides along the switch


class Switched:
    """The switches of a traced function, and the parameters with which a solve calls it."""

    def __init__(self, bound):
        self.fun = bound.held.fun
        self.args = bound.held.args
        self.function = bound.function
        self.n = bound.n
        self.graph = self.function.traced.trace.graph
        self.outputs = self.function.derived("with signs", self._with_signs)
        self.all = self.function.derived("switches", self._found)

    def _with_signs(self):
        return with_signs(self.graph, self.function.traced.stored)

    def _found(self):
        size = len(live(self.outputs))
        if size > LARGEST:
            return []
        try:
            found = switches(self.graph, self.outputs, self.n)
        except (Refusal, Untraceable):
            return []
        return found if size * 3 ** min(MOST, len(found)) <= LARGEST else []

    def given(self, fun=None, args=None):
        """The types and values of the parameters; None if the trace does not hold any more."""
        found = Attempt(fun or self.fun, args or self.args, DERIVATIVE, self.n).known()
        if found is None or found[0].function is not self.function:
            return None
        return list(zip(found[0].traced.kinds, found[1], strict=True))

    def values(self, nodes, t, y, given=None):
        """The values of nodes at one point."""
        given = (self.given() or []) if given is None else given
        numbers = flat([value for _, value in given])
        return evaluate(self.graph, nodes, np.array([t]), y[:, None], numbers)[0][:, 0]

    def times(self, t0, tf):
        """The times at which the function switches whatever the state, in the order of the span."""
        switches = self.function.traced.switches
        given = self.given()
        if switches is None or given is None:
            return np.empty(0)
        found = switches.times(flat([value for _, value in given]), t0, tf).t
        return found if tf >= t0 else found[::-1]

    def slides(self, t, y, h):
        """The indices of the switches along which a solution slides, or rests, at a state.

        `h` is the length of steps; steps across a switch end at about this distance.
        """
        return [
            k for k, (d, size, up, down) in enumerate(self._distances(t, y))
            if up <= 0.0 <= down and up < down
            and abs(d) <= STEPS * h * max(-up, down) + ROUNDING * size
        ]  # fmt: skip

    def reached(self, t, y, within):
        """The indices of the switches that a solution meets within a time, at its present rate."""
        return [
            k for k, (d, size, up, down) in enumerate(self._distances(t, y))
            if abs(d) <= within * max(abs(up), abs(down)) + ROUNDING * size
        ]  # fmt: skip

    def crossed(self, times, states):
        """The indices of the switches on both sides of which states at times lie."""
        sides = np.array(
            [self._distances(*at)[:, 0] > 0.0 for at in zip(times, states, strict=True)]
        )
        return np.flatnonzero(sides.any(axis=0) & ~sides.all(axis=0))

    def _distances(self, t, y):
        """Of each switch: the difference, its size, its rates on both sides."""
        if not self.all or self.given() is None:
            return np.empty((0, 4))
        nodes = [x for s in self.all for x in (s.difference, s.size, *s.rates)]
        return self.values(nodes, t, y).reshape(-1, 4)


def has_switches(function):
    """Whether few conditions on the state select among formulas of a Function without tables."""
    found = function.notes.get("has switches")
    if found is None:
        traced = function.traced
        nodes = decisions(traced.trace.graph, traced.stored, ())
        ops = {each.op for each in live(traced.stored)}
        others = any(OPERATIONS[op].tables or OPERATIONS[op].whole for op in ops)
        found = function.notes["has switches"] = 0 < len(nodes) <= FEW and not others
    return found


def switched(bound):
    """The Switched of a Bound whose function was traced; None for other functions."""
    function = bound.function
    if function is None or bound.mode is not DERIVATIVE or not made(function):
        return None
    if isinstance(bound.held.fun, Part):
        return None
    return None if function.traced.in_batches or bound.pair else Switched(bound)


class Part:
    """One function of the longer state, see `Hybrid`: the derivative, an event, a new state.

    Without machine code, the nodes are computed by NumPy, and the derivative away from all switches
    by the user's function.
    """

    direction = -1.0  # of an event, which falls through zero

    def __init__(self, of, nodes, chosen, name, own: Any = None):
        self.of = of
        self.nodes = nodes
        self.chosen = chosen
        self.own = own
        self.__name__ = name

    def __call__(self, t, z, *args):
        of = self.of
        z = np.asarray(z, float)
        if self.own is not None:
            y, modes = z[: of.n].copy(), z[of.n : of.n + len(self.chosen)]
            apart = of.values([s.difference for s in self.chosen], t, z)
            if np.all(modes * apart > 0.0):
                own = in_python(lambda t, y: self.own(t, y, *args), DERIVATIVE, t, y)
                return [*own, *[0.0] * (ADDED * len(modes))]
        found = of.values(self.nodes, t, z).tolist()
        return found if len(found) > 1 else found[0]

    def bound(self, mode, n, args):
        """The Bound of the compiled nodes; None if the trace does not hold any more."""
        of = self.of
        given = of.given(None, args)
        if given is None:
            return None
        traced = of.function.traced
        place = "switched", mode, tuple([node.key for node in self.nodes])
        raising = None if self.own is not None else of.graph.false
        made = traced.with_outputs(self.nodes, mode, n, raising)
        function = of.function.derived(place, lambda: made.compiled(of.function.seconds))
        held = Held(self, args)

        def as_written(t, z):
            return held.fun(t, z, *held.args)

        return with_code(function, as_written, held, given, mode, n, traced.at)


def parts(of, chosen, widths, t0, y0):
    """The modes at the start; the derivative, the events and the changes of modes, as Parts.

    `chosen` are indices of the switches; for `widths` see `switches.hybrid`.
    """
    n = of.n
    some = [of.all[k] for k in chosen]
    place = "hybrid", tuple(chosen), *widths
    whole = of.function.derived(place, lambda: hybrid(of.graph, of.outputs, some, *widths))
    state = [of.graph.make("y", (), i) for i in range(n + ADDED * len(some))]
    modes = _first_modes(of, some, t0, y0)
    fun = Part(of, whole.outputs, some, getattr(of.fun, "__name__", "fun"), of.fun)
    events = []
    jumps = []
    zero = of.graph.const(0.0)
    for k, behind in enumerate(whole.modes):
        here = whole.leaving[EVENTS * k : EVENTS * (k + 1)]
        for event, mode in zip(here, behind, strict=True):
            events.append(Part(of, [event], some, f"switch {k}"))
            jumped = list(state)
            jumped[n + k] = mode
            jumped[n + len(some) + k] = zero
            jumps.append(Part(of, jumped, some, f"mode {k}"))
    return modes, fun, events, jumps


def behind_jumps(of, chosen, widths, times, t_end):
    """The change of modes, a Part, at times at which the differences of switches may jump.

    A solution that is farther from a switch than the `widths` of `hybrid` is on the side of the
    difference there; one that is nearer keeps its mode, which events change.
    """
    n = of.n
    g = of.graph
    some = [of.all[k] for k in chosen]
    width, share, _ = widths
    behind = BEHIND * max(abs(t) for t in (*times, 1e-300)) * (1.0 if t_end > times[0] else -1.0)
    now = g.make("t")
    later = {now.key: g.add(now, g.const(behind))}
    jumped = [g.make("y", (), i) for i in range(n + ADDED * len(some))]
    zero = g.const(0.0)
    one = g.const(1.0)
    for k, switch in enumerate(some):
        difference, size = forced(g, [switch.difference, switch.size], {}, later)
        width_here = g.add(g.mul(g.const(share), size), g.const(width))
        side = g.select(g.compare(zero, difference, "lt"), one, g.const(-1.0))
        far = g.compare(width_here, g.make("abs", (difference,)), "lt")
        jumped[n + k] = g.select(far, side, jumped[n + k])
        jumped[n + len(some) + k] = g.select(far, zero, jumped[n + len(some) + k])
    return Part(of, jumped, some, "modes behind a jump")


def leaves(of, chosen, widths, t, z):
    """Whether a longer state is far from a switch on which its mode keeps the solution."""
    n = of.n
    some = [of.all[k] for k in chosen]
    width, share, _ = widths
    found = of.values([x for s in some for x in (s.difference, s.size)], t, z[:n]).reshape(-1, 2)
    far = np.abs(found[:, 0]) > FAR * (width + share * found[:, 1])
    return bool(np.any(far & (np.abs(z[n : n + len(some)]) < 0.5)))


def _first_modes(of, some, t0, y0):
    found = of.values([x for s in some for x in (s.difference, *s.rates)], t0, y0).reshape(-1, 3)
    return [
        np.sign(d) if d else 0.0 if up < 0.0 < down else 1.0 if up > 0.0 or not up < 0 else -1.0
        for d, up, down in found
    ]


def followed(of, jumping, sliding):
    """The indices of the switches that are followed by modes, each of which triples the formulas.

    All at which the function jumps; if these make too many formulas, those along which the solution
    slides: at the others the steps of a pair find the jump.  None, if these make too many, too.
    """
    size = len(live(of.outputs))
    for found in (set(jumping), set(jumping).intersection(sliding)):
        if size * 3 ** len(found) <= LARGEST:
            return sorted(found)
    return []


def jumping(of, t, y):
    """The indices of the switches at whose surface, seen from one state, the function jumps."""
    given = of.given()
    found = []
    for k, switch in enumerate(of.all):
        at = y
        for _ in range(NEWTON):  # to the surface
            d, *slope = of.values([switch.difference, *switch.slope[:-1]], t, at, given)
            at = at - d * np.array(slope) / max(np.dot(slope, slope), 1e-300)
        up, down = (of.values(list(side), t, at, given) for side in switch.sides)
        if not np.allclose(up, down, rtol=JUMP, atol=JUMP * np.abs([up, down]).max()):
            found.append(k)
    return found
