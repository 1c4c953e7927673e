"""The methods of a page in JavaScript, written from the tables of `kernels/methods`."""

import json

from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.gauss.methods import extrapolation

ADAPTIVE = "RK45"
FIXED = ("RK4", "EnergyConserving2")
SECOND_ORDER = "VelocityVerlet"
NAMES = (ADAPTIVE, "RK4", SECOND_ORDER, "EnergyConserving2")
WORDS = {
    "RK45": "adapts its steps to the tolerance",
    "RK4": "constant steps, order 4",
    "VelocityVerlet": "constant steps, symplectic",
    "EnergyConserving2": "constant steps, conserves energy",
}


def offered(second_order, phases):
    """Names of the methods for a system: `second_order` if q'' = a(t, q), `phases` if in phases."""
    if phases:  # with projections, which the other methods do not take
        return [name for name in NAMES if METHODS[name].projects]
    return [name for name in NAMES if second_order or name != SECOND_ORDER]


def text():
    """The declaration of METHODS in JavaScript."""
    lines = [f"  {name}: {{{', '.join(_fields(name))}}}," for name in NAMES]
    return "\n".join(["const METHODS = {", *lines, "};", ""])


def _fields(name):
    facts = METHODS[name]
    table = facts.code.tableau
    found = {"name": name, "words": WORDS[name], "order": facts.order}
    found["fixed"] = not facts.error_order
    fields = [f"{key}: {json.dumps(value)}" for key, value in found.items()]
    if "a" in table:
        return fields + _explicit(table, facts)
    if "kicks" in table:
        drifts = table["drifts"]
        times = [float(sum(drifts[: i + 1])) for i in range(len(drifts))]
        listed = {"kicks": _floats(table["kicks"]), "drifts": _floats(drifts), "times": times}
        return [*fields, 'loop: "kicks"', f"table: {json.dumps(listed)}"]
    listed = {
        "mu": [_floats(row) for row in table["mu"]], "b": _floats(table["b"]),
        "c": _floats(table["c"]), "rows": [_floats(row) for row in table["rows"]],
        "ratio": [_floats(row) for row in extrapolation(len(table["b"]))],
    }  # fmt: skip
    return [*fields, 'loop: "stages"', f"table: {json.dumps(listed)}"]


def _floats(values):
    return [float(x) for x in values]


def _explicit(table, facts):
    """The step of an explicit method, its error and its dense output, as straight lines."""
    c = table["c"].floats
    stages = table["a"]
    s = facts.n_stages
    lines = []
    for i in range(1, s + 1):
        lines.append(_each(f"u[i] = y[i] + h * ({_sum(stages[i].floats)})"))
        at = "t + h" if c[i] == 1.0 else f"t + {c[i]!r} * h"
        lines.append(f"if (f({at}, u, p, k[{i}])) return true;")
    lines.append("return false;")
    adaptive = bool(facts.error_order)
    fields = [
        f'loop: "{"pair" if adaptive else "single"}"', f"stages: {s}",
        f"step(f, t, h, y, p, k, u) {{ const n = y.length; {' '.join(lines)} }}",
    ]  # fmt: skip
    if adaptive:
        error = _each(f"out[i] = h * ({_sum(table['e'][0].floats)})")
        dense = "".join(
            _each(f"d[{4 + j}][i] = h * ({_sum(row.floats)})") for j, row in enumerate(table["d"])
        )
        fields += [
            f"exponent: {-1.0 / (facts.error_order + 1)!r}", f"more: {len(table['d'])}",
            f"error(h, k, out) {{ const n = out.length; {error} }}",
            f"dense(h, k, d) {{ const n = d[0].length; {dense} }}",
        ]  # fmt: skip
    return fields


def _each(statement):
    return f"for (let i = 0; i < n; i++) {statement};"


def _sum(row):
    terms = [f"{x!r} * k[{j}][i]" for j, x in enumerate(row) if x]
    return " + ".join(terms).replace("+ -", "- ")
