"""Graphs with other nodes in the place of some."""

from .expressions import is_zero, live


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
    if node.op == "mul" and any(map(is_zero, args)):
        return graph.const(0.0)
    if node.op in ("add", "sub") and any(map(is_zero, args)):
        a, b = args
        return a if is_zero(b) else b if node.op == "add" else graph.neg(b)
    if node.op == "div" and is_zero(args[0]):
        return args[0]
    return graph.call(node.op, *args, data=node.data)
