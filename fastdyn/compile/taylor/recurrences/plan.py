"""The plan of a function: its recurrences in the order of evaluation."""

import math
from collections import Counter

from fastdyn.trace.graph.refusal import refused_as
from fastdyn.trace.graph.signs import signed
from fastdyn.trace.operations import OPERATIONS

from . import deceptive
from .factors import Scaled, share_factors
from .listing import items, nodes
from .operations import Choice, Integral, Power, Quotient, Root, Sum
from .rewrite import NotSmooth, Rewriter

SUMS = frozenset(("add", "sub", "mul"))
# Terms that count as one sum of products.  For a dense network of 20 neurons, 400 terms, a step
# takes 3 us with like nodes in the lanes, else 7; a matrix of 63 x 63 has 500 terms, which take 3 s
# in straight-line code.
TERMS = 4


def sums_of_terms(steps):
    """The number of sums as which the terms of steps count, such as elements of a matrix."""
    return sum(len(step.terms) for step in steps if isinstance(step, Sum)) // TERMS


class Plan:
    """The recurrences of functions of t and y.

    Parameters
    ----------
    graph : Graph
    outputs : list of Node
    raising : Node
        The condition under which the function raises.

    Attributes
    ----------
    steps : list of Sum, Quotient, Power, Root, Integral, Choice
        Each step after its operands.
    outputs : list of (Node, Node)
        The invariant factor and the node of each output; the node of an invariant is None.
    switch : dict of (Node, Node)
        By the key of a comparison, the difference of its two sides, as (factor, node).
    watched : dict of Node
        By key, the nodes that decide where a step ends.
    signed, rooted : set
        Keys of `watched`.  `signed`: the differences of `switch` and the first arguments of atan2,
        which must not change sign on a step.  `rooted`: the arguments of roots, which must not
        touch zero; the series of sqrt(x^2) = |x| would continue as the series of x or -x.
    held : dict of Hold
        By key of `watched`, the arguments of functions that may deceive: see `deceptive.py`.
    invariants : dict of Node
        By key, the invariants of the steps, without constants.
    level : dict of int
        By the key of a node, the length of the longest chain of recurrences to the node.

    Raises
    ------
    NotSmooth
    """

    @refused_as(NotSmooth)
    def __init__(self, graph, outputs, raising):
        self.graph, self.rewrite = graph, Rewriter(graph)
        graph.most = math.inf  # the size of this function has been accepted
        self.one, self.scaled = graph.const(1.0), Scaled(self.rewrite)
        self.uses: Counter = Counter()
        self.switch: dict = {}
        roots = [self.scaled(self.rewrite(node)) for node in signed(graph, outputs)]
        self.raising = self.rewrite(raising)
        others = [self.switch[node.key][1] for node in self._compared(self.raising)]
        cores = self._cores([core for _, core in roots] + others)
        self.steps = self._steps(cores, roots)
        self.outputs = [self._output(*root) for root in roots]
        self.watched, self.signed, self.rooted, self.held = self._watched()
        share_factors(self.steps, self.uses, graph)
        self.level, self.degree = self._levels()
        self.invariants = self._invariants()

    @property
    def n_sums(self):
        """The number of sums of products in an order."""
        return sum(
            len(s.products) if isinstance(s, Sum)
            else len(s.parts) if isinstance(s, Integral)
            else not isinstance(s, Choice)
            for s in self.steps
        )  # fmt: skip

    def is_smooth(self):
        """True if no condition, of varying numbers or of invariants, selects between formulas."""
        return not self.signed and not any(isinstance(step, Choice) for step in self.steps)

    def raises(self):
        """True if the function may raise."""
        return self.raising is not self.graph.false

    # -- nodes

    def _operands(self, core):
        """The nodes whose coefficients of order k the recurrence for order k needs."""
        inner = self.scaled(core)[1]
        if inner is not core:  # core is a multiple of `inner`, and is used itself
            return [inner]
        if core.op == "select":
            args = [*core.args[1:], *[self.switch[c.key][1] for c in self._compared(core.args[0])]]
            return [a for a in args if a is not None and not self.rewrite.is_invariant(a)]
        if core.op in ("sqrt", "power") or OPERATIONS[core.op].elementary:
            return [a for a in core.args if not self.rewrite.is_invariant(a)]
        return [a for _, a in map(self.scaled, core.args) if a is not None]

    def _slopes(self, core):
        """(f, argument, g) for each argument of a function; g is None for an invariant slope."""
        found = [(a, self.scaled(g)) for a, g in self.rewrite.slopes(core)]
        return [(f, a, g) for a, (f, g) in found]

    def _compared(self, condition):
        """The comparisons in a condition; each gets an entry in `switch`."""
        g = self.graph
        found = []
        todo = [condition]
        while todo:
            node = todo.pop()
            if self.rewrite.is_invariant(node):
                continue
            if OPERATIONS[node.op].sign:
                found.append(node)
                if node.key not in self.switch:
                    self.switch[node.key] = self.scaled(self.rewrite(g.sub(*node.args)))
            else:
                todo += node.args
        return found

    def _cores(self, roots):
        """All cores in topological order; counts their uses."""
        order = []
        seen = set()
        roots = list(roots)
        for root in roots:  # the list grows
            todo = [] if root is None else [(root, False)]
            self.uses.update(core.key for core, _ in todo)
            while todo:
                core, ready = todo.pop()
                if ready:
                    order.append(core)
                elif core.key not in seen:
                    seen.add(core.key)
                    operands: list = self._operands(core)
                    self.uses.update(a.key for a in operands)
                    todo.append((core, True))
                    todo += [(a, False) for a in operands]
                    if OPERATIONS[core.op].elementary:
                        roots += [g for _, _, g in self._slopes(core)]
        return order

    # -- recurrences

    def _steps(self, cores, roots):
        """The recurrences; a sum or product with a single use becomes part of a sum."""
        outer = {core.key: f for f, core in roots if core is not None}
        taken = set()
        steps = []
        for core in reversed(cores):
            if core.key in taken or core.op in ("t", "y"):
                continue
            if core.op in SUMS or self.scaled(core)[1] is not core:
                factor = outer.get(core.key, self.one) if self.uses[core.key] == 1 else self.one
                steps.append(self._sum(core, factor, taken))
            else:
                steps.append(self._step(core))
        return steps[::-1]

    def _sum(self, core, factor, taken):
        """A sum, with inner sums and products of a single use taken in."""
        g = self.graph
        constant = None
        terms = []
        products = []
        todo = [(factor, core)]
        while todo:
            outer, node = todo.pop()
            f, a = self.scaled(node)
            f = g.mul(outer, f)
            if a is None:
                constant = f if constant is None else g.add(constant, f)
            elif a.op not in SUMS or (a is not core and self.uses[a.key] > 1):
                terms.append((f, a))
            else:
                taken.add(a.key)
                if a.op == "mul":
                    products.append((f, *a.args))
                else:
                    left, right = a.args
                    todo += [(f if a.op == "add" else g.neg(f), right), (f, left)]
        return Sum(core, constant, terms, products)

    def _step(self, core):
        if core.op == "div":
            (f, a), (h, b) = map(self.scaled, core.args)
            return Quotient(core, self.graph.div(f, h), b, a)
        if core.op == "power":
            return Power(core, self.one, core.args[0], core.data)
        if core.op == "sqrt":
            return Root(core, core.args[0])
        if core.op == "select":
            return Choice(core, *core.args)
        return Integral(core, core.op, list(core.args), self._slopes(core))

    def _watched(self):
        signed = [core for _, core in self.switch.values() if core is not None]
        rooted = []
        for step in self.steps:
            if deceptive.root(step):  # the series of steeper poles shorten the steps
                rooted.append(step.a)
            if isinstance(step, Integral) and step.name == "atan2":
                signed += [a for a in step.arguments[:1] if not self.rewrite.is_invariant(a)]
        keys = ({core.key for core in cores} for cores in (signed, rooted))
        held = {hold.node.key: hold for hold in filter(None, map(deceptive.transition, self.steps))}
        cores = signed + rooted + [hold.node for hold in held.values()]
        return {core.key: core for core in cores}, *keys, held

    def _output(self, factor, core):
        whole = core is not None and core.op in SUMS and self.uses[core.key] == 1
        return (self.one, core) if whole else (factor, core)

    def leaves(self):
        """The nodes of state and time that order 0 needs, by key."""
        found = [x for step in self.steps for x in nodes(step)]
        found += [core for _, core in self.outputs if core is not None]
        found += self.watched.values()
        return {x.key: x for x in found if x.op in ("t", "y")}

    def _levels(self):
        """The level of each node, and its degree in time if the degree is 0 or 1."""
        level = {}
        degree = {}
        for step in self.steps:
            needs = [x for known, x in items(step, self.rewrite.is_invariant) if not known]
            if isinstance(step, Integral):  # c[k] needs no g[k]
                needs = [a for _, a, _ in step.parts]
            for a in needs:
                if a.op in ("t", "y"):
                    level[a.key], degree[a.key] = 0, 1 if a.op == "t" else None
            level[step.node.key] = 1 + max((level.get(a.key, 0) for a in needs), default=0)
            linear = isinstance(step, Sum) and not step.products
            degrees = [degree.get(a.key) for a in needs]
            degree[step.node.key] = 1 if linear and None not in degrees else None
        return level, degree

    def _invariants(self):
        """The invariant nodes of the recurrences, without constants."""
        found = [f for f, _ in (*self.outputs, *self.switch.values())]
        found += [c for c in self._conditions() if self.rewrite.is_invariant(c)]
        for step in self.steps:
            found += [x for known, x in items(step, self.rewrite.is_invariant) if known]
        return {f.key: f for f in found if f.op != "const"}

    def _conditions(self):
        """All parts of all conditions, down to invariant parts."""
        todo = [step.condition for step in self.steps if isinstance(step, Choice)]
        todo.append(self.raising)
        found = []
        while todo:
            node = todo.pop()
            found.append(node)
            if not self.rewrite.is_invariant(node) and node.key not in self.switch:
                todo += node.args
        return found
