"""Graphs with other nodes in the place of some."""

from fastdyn.trace.graph.expressions import is_zero, live

ARITHMETIC = ("neg", "add", "sub", "div")  # methods of Graph that simplify
CONDITIONS = ("and", "or")


def substituted(graph, outputs, inputs):
    """The outputs with the nodes of the keys of `inputs` replaced; products with zero vanish."""
    found = dict(inputs)
    for node in live(outputs):
        if node.key not in found:
            args = [found[a.key] for a in node.args]
            same = all(a is b for a, b in zip(args, node.args, strict=True))
            found[node.key] = node if same else _made(graph, node, args)
    return [found[node.key] for node in outputs]


def _made(graph, node, args):
    if node.op == "mul":
        return graph.const(0.0) if any(map(is_zero, args)) else graph.mul(*args)
    if node.op in ("add", "sub") and any(map(is_zero, args)):
        a, b = args
        return a if is_zero(b) else b if node.op == "add" else graph.neg(b)
    if node.op == "div" and is_zero(args[0]):
        return args[0]
    if node.op in ARITHMETIC:
        return getattr(graph, node.op)(*args)
    if node.op in CONDITIONS:
        return graph.both(*args, node.op)
    if node.op == "not":
        return graph.negation(*args)
    if node.op == "select":
        return graph.select(*args)
    return graph.make(node.op, args, node.data)
