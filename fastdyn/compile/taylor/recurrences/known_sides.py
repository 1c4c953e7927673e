"""Choices between a varying and an invariant number, for example max(y, 0)."""


def known_side(rewrite, x):
    """(condition, side, side) of a choice with an invariant side; None for other nodes.

    The choice may be scaled and shifted by invariants.
    """
    if x.op == "select" and any(map(rewrite.is_invariant, x.args[1:])):
        return x.args
    if x.op not in ("add", "sub", "neg", "mul", "div"):
        return None
    varying = [i for i, arg in enumerate(x.args) if not rewrite.is_invariant(arg)]
    parts = known_side(rewrite, x.args[varying[0]]) if len(varying) == 1 else None
    if parts is None:
        return None
    at, combine = varying[0], getattr(rewrite.graph, x.op)
    return parts[0], *[combine(*x.args[:at], side, *x.args[at + 1 :]) for side in parts[1:]]
