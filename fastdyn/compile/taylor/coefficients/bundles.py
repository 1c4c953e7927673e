"""The vectors of a plan: one vector for each node, or, if the plan is large, for like nodes.

Like nodes have equal formulas.
"""

import copy

from ..recurrences.likeness import alike
from ..recurrences.listing import Gather, Rate, items, rebuilt, timed
from ..recurrences.operations import Sum
from .looped import Part, looped

MAX_PRODUCTS = 4  # most products in a sum


class Single:
    """The vectors of a plan, one for each node, with one trajectory in each lane.

    Attributes
    ----------
    states : list of Node
    components : list of int
        The component in each lane of the states.
    time : Node or None
    steps, rates : list
    factors : list of Node
        The invariants.
    level : dict of int
        As in `Plan`.
    timed : set
        The keys of functions whose argument is linear in time: such functions need no sum.
    """

    def __init__(self, plan):
        g = plan.graph
        self.level = plan.level
        self.components = range(len(plan.outputs))
        self.states = [g.make("y", (), i) for i in self.components]
        self.time, self.factors = g.make("t"), list(plan.invariants.values())
        self.steps, self.timed = plan.steps, timed(plan)
        self.rates = [
            Rate(y, None, None, f) if core is None else Rate(y, f, core, None)
            for y, (f, core) in zip(self.states, plan.outputs, strict=True)
        ]

    def parts(self, places):
        """(parts of steps, parts of rates), in the order of emission."""
        return [Part(self.steps)], [Part(self.rates)]


def spread(plan):
    """A copy of a plan that splits each long sum of products into steps of one product each."""
    found = copy.copy(plan)
    made = {}
    steps: list = []
    for step in plan.steps:
        if isinstance(step, Sum) and len(step.products) > MAX_PRODUCTS:
            terms = list(step.terms)
            for f, a, b in step.products:
                node = plan.graph.mul(a, b)
                if node.key not in made:
                    made[node.key] = Sum(node, None, [], [(plan.one, a, b)])
                    steps.append(made[node.key])
                terms.append((f, node))
            step = Sum(step.node, step.constant, terms, [])
        steps.append(step)
    found.steps = steps
    found.level, found.degree = found._levels()
    return found


class Bundle:
    """Like nodes, or invariants, one in each lane."""

    def __init__(self, nodes, lanes, is_factor=False):
        nodes = [*nodes, *[nodes[-1]] * (lanes - len(nodes))]
        self.is_factor = is_factor
        self.nodes, self.key = nodes, tuple([node.key for node in nodes])
        same = all(node is nodes[0] for node in nodes)
        self.op, self.data = (nodes[0].op, nodes[0].data) if same else ("many", None)


class Bundles:
    """The vectors of a plan, with like nodes in the lanes; attributes as in `Single`.

    Parameters
    ----------
    plan : Plan
    lanes : int
    """

    def __init__(self, plan, lanes):
        self._lanes = lanes
        self._known = {}
        self._lane = {}
        self.graph = plan.graph
        self._gathers, self._factors, self.level, self.timed = [], {}, {}, set()
        plan = self._plan = spread(plan)
        states, groups = alike(plan, lanes)
        y = [plan.graph.make("y", (), i) for i in range(len(plan.outputs))]
        time = plan.graph.make("t")
        in_time = timed(plan)
        self.states = [self._new([y[i] for i in chunk]) for chunk in states]
        whole = self._new([time])
        for group in groups:
            node = self._new([step.node for step in group], plan.level[group[0].node.key])
            if group[0].node.key in in_time:
                self.timed.add(node.key)
        self._uses_time = False
        made = [self._bundled(group) for group in groups]
        self.rates = [self._rate(*each) for each in zip(self.states, states, strict=True)]
        self.steps = sorted([*made, *self._gathers], key=lambda s: self.level[s.node.key])
        self.time = whole if self._uses_time else None
        self.factors = list(self._factors.values())
        lanes = {node.key: node for f in self.factors for node in f.nodes}
        self.invariants = plan.invariants | lanes
        self.components = [node.data for vector in self.states for node in vector.nodes]

    # -- vectors

    def _new(self, nodes, level=0):
        bundle = Bundle(nodes, self._lanes)
        self._known[bundle.key] = bundle
        self.level[bundle.key] = 2 * level
        for lane, node in enumerate(bundle.nodes):
            self._lane.setdefault(node.key, (bundle, lane))
        return bundle

    def _of(self, nodes):
        """The vector with these nodes in its lanes, gathered from other vectors if necessary."""
        wanted = Bundle(nodes, self._lanes)
        self._uses_time |= any(node.op == "t" for node in nodes)
        if wanted.key not in self._known:
            lanes = [self._lane[node.key] for node in wanted.nodes]
            level = max(self.level[bundle.key] for bundle, _ in lanes)
            self._known[wanted.key] = wanted
            self.level[wanted.key] = level + 1
            self._gathers.append(Gather(wanted, lanes))
        return self._known[wanted.key]

    def _factor(self, nodes):
        wanted = Bundle(nodes, self._lanes, True)
        if wanted.op == "const":
            return wanted
        return self._factors.setdefault(wanted.key, wanted)

    # -- steps

    def _bundled(self, group):
        """One step on vectors, made from a group of like steps."""
        node = self._known[Bundle([step.node for step in group], self._lanes).key]
        invariant = self._plan.rewrite.is_invariant
        lists = zip(*[items(step, invariant) for step in group], strict=True)
        given = [
            self._factor([x for _, x in each]) if each[0][0] else self._of([x for _, x in each])
            for each in lists
        ]
        return rebuilt(group[0], node, given)

    def _rate(self, bundle, states):
        """The Rate of a vector of states; single lanes may have constant derivatives."""
        outputs = [self._plan.outputs[i] for i in states]
        zero = self._plan.graph.const(0.0)
        cores = [core for _, core in outputs if core is not None]
        if not cores:
            return Rate(bundle, None, None, self._factor([f for f, _ in outputs]))
        factor = self._factor([zero if core is None else f for f, core in outputs])
        core = self._of([cores[0] if core is None else core for _, core in outputs])
        if len(cores) == len(outputs):
            return Rate(bundle, factor, core, None)
        constant = self._factor([f if core is None else zero for f, core in outputs])
        return Rate(bundle, factor, core, constant)

    def parts(self, places):
        """See `Single.parts`."""
        return looped(self, places, self.steps, "part"), looped(self, places, self.rates, "rate")
