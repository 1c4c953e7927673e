"""A graph in mpmath's numbers, and its derivatives by differences: an oracle without rounding."""

import mpmath
import numpy as np
from mpmath import mp

from fastdyn.trace.graph.expressions import live
from fastdyn.trace.operations import OPERATIONS

DIGITS, STEP = 60, "1e-20"
FUNCTIONS = {
    "cbrt": lambda x: mp.sign(x) * mp.cbrt(abs(x)), "expm1": mp.expm1, "log1p": mp.log1p,
    "exp2": lambda x: mp.mpf(2) ** x, "log2": lambda x: mp.log(x, 2), "log10": mp.log10,
    "pow": lambda a, b: mp.mpf(a) ** b, "fmod": lambda a, b: a - mp.mpf(_trunc(a / b)) * b,
    "tgamma": mp.gamma, "lgamma": lambda x: mp.log(abs(mp.gamma(x))),
}  # fmt: skip
ROUND = {"floor": mp.floor, "ceil": mp.ceil, "rint": mp.nint, "trunc": lambda x: _trunc(x)}
TRUTH = {"lt": lambda a, b: a < b, "le": lambda a, b: a <= b, "eq": lambda a, b: a == b}


def _trunc(x):
    return mp.floor(x) if x >= 0 else mp.ceil(x)


def values(graph, outputs, t, y, parameters):
    """The values of nodes, each an mpf or a truth; NaN where there is none."""
    found = {}
    for node in live(outputs):
        args = [found[a.key] for a in node.args]
        try:
            found[node.key] = _value(graph, node, args, t, y, parameters)
        except (ValueError, ZeroDivisionError, mpmath.libmp.ComplexResult):
            found[node.key] = mp.nan
        if isinstance(found[node.key], mp.mpc):
            found[node.key] = mp.nan
    return [found[node.key] for node in outputs]


def _value(graph, node, args, t, y, parameters):
    op, data = node.op, node.data
    leaves = {"t": lambda: t, "y": lambda: y[data], "par": lambda: parameters[data]}
    if op in leaves:
        return leaves[op]()
    if op == "const":
        return data if isinstance(data, bool) else mp.mpf(data)
    if OPERATIONS[op].elementary:
        return FUNCTIONS.get(op, getattr(mp, op, None))(*args)
    if op in ROUND:
        return ROUND[op](args[0])
    if op in TRUTH:
        return TRUTH[op](*args)
    if op == "select":
        return args[1] if args[0] else args[2]
    plain = {
        "neg": lambda a: -a, "add": lambda a, b: a + b, "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b, "div": lambda a, b: a / b, "sqrt": mp.sqrt, "abs": abs,
        "and": lambda a, b: a and b, "or": lambda a, b: a or b, "not": lambda a: not a,
    }  # fmt: skip
    return plain[op](*args) if op in plain else _from_table(graph, op, data, args[0], parameters)


def _from_table(graph, op, data, x, parameters):
    def content(name):
        table = graph.tables[name]
        return [parameters[i] for i in table] if isinstance(table, range) else list(table)

    if op == "table":
        table, i = content(data), int(x)
        return mp.mpf(table[min(max(i + len(table) if i < 0 else i, 0), len(table) - 1)])
    knots = content(data[0])
    if op == "search":
        return mp.mpf(sum(k < x if data[1] == "left" else k <= x for k in knots))
    i = min(max(sum(k <= x for k in knots) - 1, 0), len(knots) - 2)
    if op == "piecewise":
        return mp.polyval([mp.mpf(content(c)[i]) for c in data[1:]], x - mp.mpf(knots[i]))
    heights = [mp.mpf(v) for v in content(data[1])]
    width = mp.mpf(knots[i + 1]) - knots[i]
    return heights[i] + (heights[i + 1] - heights[i]) / width * (x - knots[i])


def differences(graph, outputs, t, y, parameters, wrt):
    """d outputs / d inputs by central differences: off by 1e-40 times the third derivatives.

    `wrt` are (kind, index), kind "y", "par" or "t".
    """
    columns = []
    with mp.workdps(DIGITS):
        for kind, i in wrt:
            sides = []
            for sign in (1, -1):
                given = {"t": [mp.mpf(t)], "y": list(map(mp.mpf, y))}
                given["par"] = list(map(mp.mpf, parameters))
                given[kind][i] += sign * mp.mpf(STEP)
                sides.append(values(graph, outputs, given["t"][0], given["y"], given["par"]))
            columns.append([(a - b) / (2 * mp.mpf(STEP)) for a, b in zip(*sides, strict=True)])
    return np.array(columns, dtype=object).T


def exactly(graph, nodes, t, y, parameters):
    """The values of nodes in many digits."""
    with mp.workdps(DIGITS):
        given = [mp.mpf(t), list(map(mp.mpf, y)), list(map(mp.mpf, parameters))]
        return np.array(values(graph, nodes, *given), dtype=object)
