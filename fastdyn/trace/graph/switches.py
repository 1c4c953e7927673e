"""Switches: surfaces in the space of states at which a function jumps, and the motion along them.

On both sides of a surface d(t, y) = 0 the function is smooth, f+ where d > 0 and f- where d < 0.
If both point at the surface, d' < 0 above and d' > 0 below, the solution stays on the surface and
moves with the average of f+ and f- for which d' = 0: A. F. Filippov, "Differential Equations with
Discontinuous Righthand Sides", 1988, section 4.
"""

from typing import Any, NamedTuple

from .derivatives import partials
from .expressions import live
from .jumps import decisions
from .signs import forced

AT_REST = 1e-9  # share of f+ in the average with which a solution that rests leaves a switch
BEYOND = 1.0  # the average is smooth up to this share beyond f+ and f-: events locate its end
MOST = 3  # switches of a function; each makes three formulas of one
LARGEST = 20_000  # most formulas


class Switch(NamedTuple):
    """A surface: the difference of two numbers, and what is true of comparisons beside it.

    `above` and `below` have the truth of comparisons by key, where the difference is positive and
    negative; `size` is the size of the two numbers.  `slope` is the derivative of the difference
    by state and time, `rates` are its derivatives along f+ and along f-, and `sides` are f+ and f-.
    """

    difference: Any
    above: dict
    below: dict
    size: Any
    slope: tuple = ()
    rates: tuple = ()
    sides: tuple = ()


def switches(graph, outputs, n):
    """The Switches of the outputs, n derivatives of the state.

    Raises
    ------
    Refusal, Untraceable
        If a difference has no derivative.
    """
    found: dict = {}
    for node in _comparisons(decisions(graph, outputs, ())):
        a, b = sorted(node.args, key=lambda each: each.key)
        if (a.key, b.key) not in found:
            size = graph.add(graph.make("abs", (a,)), graph.make("abs", (b,)))
            found[a.key, b.key] = Switch(graph.sub(a, b), {}, {}, size)
        switch = found[a.key, b.key]
        less = node.op != "eq"
        switch.above[node.key] = less and node.args[0] is b
        switch.below[node.key] = less and node.args[0] is a
    return [_with_rates(graph, switch, outputs, n) for switch in found.values()]


def _comparisons(conditions):
    """The comparisons of which conditions are made."""
    found = {}
    todo = list(conditions)
    while todo:
        node = todo.pop()
        if node.op in ("lt", "le", "eq"):
            if any(each.op == "y" for each in live([node])):
                found[node.key] = node
        elif node.op in ("and", "or", "not"):
            todo += node.args
    return list(found.values())


def _with_rates(graph, switch, outputs, n):
    sides = [forced(graph, outputs, truths) for truths in (switch.above, switch.below)]
    inputs = [*[graph.make("y", (), i) for i in range(n)], graph.make("t")]
    (found,) = partials(graph, [switch.difference], inputs)
    slope = tuple([found.get(i, graph.const(0.0)) for i in range(n + 1)])
    switch = switch._replace(slope=slope, sides=tuple(sides))
    return switch._replace(rates=tuple([rate(graph, switch, side) for side in sides]))


def rate(graph, switch, side):
    """The derivative of the difference of a switch along the derivatives `side` of the state."""
    *slope, by_time = switch.slope
    return graph.sum([*map(graph.mul, slope, side), by_time])


class Hybrid(NamedTuple):
    """The nodes of a function whose state is followed by a mode of each switch: 1, -1, or 0 on it.

    Two numbers for each switch follow behind the modes.  The integral of the share of f+ has an
    error like the state, so that steps along a switch are no longer than the share is smooth; at
    rest, the state allows any length.  The `excess` is the distance to which the solution would
    have left the switch, where a step still goes on from one such time to another.

    `outputs` are the derivatives of all: state, modes, excesses, integrals.  `leaving` has, for
    each switch, three event functions that fall through zero: where the solution reaches the
    switch, where it leaves the switch, and where the excess is above its limit.  `modes` has, for
    each switch, the mode behind each of these events.
    """

    outputs: list
    leaving: list
    modes: list


def hybrid(graph, outputs, chosen, width, share_of_size, most):
    """The Hybrid of a function with some of its switches.

    Up to a distance of `width` behind a switch, plus a share of the size of the numbers that are
    compared, the mode decides which side holds: so a step across a switch is smooth, and its end
    shows the switch to the events.  Farther behind, the function jumps as it is written: a step
    that touches the other side and returns, which no event shows, has a large error and is
    rejected.  `most` is the limit of an excess.
    """
    g, n = graph, len(outputs)
    zero = g.const(0.0)
    one = g.const(1.0)
    found = [_Followed(g, n + k, switch, width, share_of_size) for k, switch in enumerate(chosen)]
    orders = [[*(each for each in found if each is not last), last] for last in found]
    orders = [(order, *_blended(g, n, outputs, order)) for order in orders]

    def last_sound(place, orders):
        """The node at ``place(order)`` of the last order that is sound."""
        result = None
        for order, nodes, sound in orders:
            node = nodes[place(order)]
            result = node if result is None else g.select(sound, node, result)
        return result

    derivatives = [last_sound(lambda order, i=i: i, orders) for i in range(n)]
    leaving = []
    modes = []
    excess = []
    shares = []
    for k, each in enumerate(found):
        own = [*orders[k + 1 :], *orders[: k + 1]]  # rates of the last switch are the safest
        up, down = (
            last_sound(lambda order, at=at, each=each: n + 2 * order.index(each) + at, own)
            for at in range(2)
        )
        least = g.select(g.compare(g.neg(up), down, "lt"), g.neg(up), down)
        least = g.add(least, g.mul(g.const(AT_REST), g.sub(down, up)))
        reached = g.mul(each.mode, each.switch.difference)
        left = g.select(g.compare(down, zero, "lt"), g.neg(down), zero)
        left = g.select(g.compare(zero, up, "lt"), up, left)
        excess.append(g.select(each.on, left, zero))
        shares.append(g.select(each.on, _share(g, up, down), zero))
        too_much = g.sub(g.const(most), g.make("y", (), n + len(found) + k))
        leaving += [g.select(each.on, a, b) for a, b in ((one, reached), (least, one))] + [too_much]
        modes.append((
            g.select(_pointing(g, up, down), zero, g.neg(each.mode)),
            g.select(g.compare(g.neg(up), down, "lt"), one, g.const(-1.0)),
            g.select(g.compare(zero, up, "lt"), one,
                     g.select(g.compare(down, zero, "lt"), g.const(-1.0), each.mode)),
        ))  # fmt: skip
    return Hybrid([*derivatives, *[zero] * len(chosen), *excess, *shares], leaving, modes)


def _pointing(g, up, down):
    """Whether both sides of a switch point at it, or one does and the other rests."""
    zero = g.const(0.0)
    both = g.both(g.compare(up, zero, "le"), g.compare(zero, down, "le"))
    return g.both(both, g.compare(up, down, "lt"))


class _Followed:
    """A switch with the nodes of its mode: `on` is true while the solution stays on the switch.

    `near` are the comparisons of the switch, which near the switch follow the mode.
    """

    def __init__(self, g, at, switch, width, share_of_size):
        self.switch, self.mode = switch, g.make("y", (), at)
        above = g.compare(g.const(0.5), self.mode, "lt")
        self.on = g.compare(g.make("abs", (self.mode,)), g.const(0.5), "lt")
        width = g.add(g.mul(g.const(share_of_size), switch.size), g.const(width))
        far = g.compare(width, g.make("abs", (switch.difference,)), "lt")
        self.near = {}
        for key, truth in switch.above.items():
            mode = above if truth else g.negation(above) if switch.below[key] else g.false
            by_mode = g.both(g.negation(far), mode)
            self.near[key] = g.both(by_mode, g.both(far, g.nodes[key]), op="or")


def _blended(g, n, outputs, followed):
    """The outputs by modes, then the rates of each switch on its two sides; whether all is sound.

    The last switch takes the average of what the switches before have on its two sides.  That is
    sound if they are at rest there, too: of two switches, one may hold the solution by the other.
    """
    if not followed:
        return outputs, g.true
    *others, last = followed
    sides = [
        _blended(g, n, forced(g, outputs, *given), others)
        for given in ((last.switch.above,), (last.switch.below,), ({}, last.near))
    ]
    (up, sound_up), (down, sound_down), (free, sound_free) = sides
    rates = [rate(g, last.switch, side[:n]) for side in (up, down)]
    share = _share(g, *rates)
    nodes = [
        c if a is b else g.select(last.on, g.add(b, g.mul(share, g.sub(a, b))), c)
        for a, b, c in zip(up, down, free, strict=True)
    ]
    sound = g.both(g.both(sound_up, sound_down), _pointing(g, *rates))
    sound = g.both(g.both(last.on, sound), g.both(g.negation(last.on), sound_free), op="or")
    return [*nodes, *rates], sound


def _share(g, up, down):
    """The share of f+ in the average; beyond its end, the share does not grow for ever."""
    share = g.div(down, g.sub(down, up))
    least = g.const(-BEYOND)
    most = g.const(1.0 + BEYOND)
    share = g.select(g.compare(share, least, "lt"), least, share)
    return g.select(g.compare(most, share, "lt"), most, share)
