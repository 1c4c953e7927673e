"""Explicit steps as text, written from a table and compiled by Numba.

No other file compiles text.  The text goes through `linecache`: tracebacks, Numba's messages,
`inspect.getsource` and ``fastdyn why --show kernel METHOD`` find its lines.  A comment gives each
stage as the paper does.
"""

import linecache
import textwrap

from ..jit.options import INLINED, njit
from ..output.dense_output import F
from ..state.elementwise import combine, weigh
from ..state.record import STAGE, Y_OLD, K, Y
from ..state.rows import slot
from .tableau import Row

KNOWN = {
    "combine": combine, "weigh": weigh, "slot": slot, "F": F, "K": K, "STAGE": STAGE, "Y": Y,
    "Y_OLD": Y_OLD,
}  # fmt: skip
WIDTH = 92  # of a comment


def _time(c, word):
    if c == 1:
        return "t + h"
    return f"t + {word if c.denominator > 1 else float(c)} * h"


def _used(row):
    """(name, coefficient as printed) of the stages that a row uses."""
    both = enumerate(zip(row.exact, row.shown, strict=True), 1)
    return [(f"k{j}", word) for j, (a, word) in both if a]


def _sum(row):
    """``3/40 k1 + 9/40 k2``, which breaks between its terms only."""
    terms = [f"{word}~{k}".removeprefix("1~") for k, word in _used(row)]
    return " +~".join(terms).replace("+~-", "-~")


def _comment(text):
    lines = textwrap.wrap(text, WIDTH, initial_indent="# ", subsequent_indent="#     ")
    return [line.replace("~", " ") for line in lines]


def _stages_of(row):
    """The tuple of the stages that a row uses."""
    names = [k for k, _ in _used(row)]
    return f"({', '.join(names)}{',' * (len(names) == 1)})"


def _without_zeros(row):
    return Row.of(a for a in row.exact if a)


def _stages(first, times, rows):
    """The lines of stages, and their rows by name."""
    lines = []
    names = {}
    for i, (*c, row) in enumerate(zip(times.exact, times.shown, rows, strict=True), first):
        time = _time(*c)
        names[f"A{i}"] = _without_zeros(row)
        lines += [
            "",
            *_comment(f"k{i} = f({time.replace(' * ', ' ')}, y + h ({_sum(row)}))"),
            f"u = combine(place, y, h, A{i}, {_stages_of(row)})",
            f"k{i} = rhs({time}, u, block, slot(form, work, K + {i - 1}))",
        ]
    return lines, names


def _compiled(name, head, lines, names):
    """The function of this head and these lines, in which `names` are known."""
    kind, _, _ = head.partition("(")
    file = f"<{kind} of {name}>"
    text = f"def {head}:\n{textwrap.indent(chr(10).join(lines), ' ' * 4)}\n"
    linecache.cache[file] = len(text), None, text.splitlines(True), file
    space = {"__name__": __name__, **KNOWN, **names}  # Numba asks for the module
    exec(compile(text, file, "exec"), space)
    space[kind].__name__ = name  # part of the name of a kernel
    return njit(**INLINED)(space[kind])


def write_step(name, table, estimate=None):
    """The step of a pair, or of a method without error estimate.

    See `adaptive.kernel` and `fixed.kernel`; `explicit.one_estimate` describes `estimate`.
    """
    end = len(table.b) + 1
    lines, names = _stages(2, *table.stages)
    lines = [
        "place = slot(form, work, STAGE)",
        *lines,
        "",
        *_comment(f"y_new = y + h ({_sum(table.b)})"),
        f"y_new = combine(slot(form, work, Y), y, h, B, {_stages_of(table.b)})",
        f"k{end} = rhs(t + h, y_new, block, slot(form, work, K + {end - 1}))",
        f"k = ({', '.join(f'k{i}' for i in range(1, end + 1))})",
    ]
    names["B"] = _without_zeros(table.b)
    if estimate is None:
        parameters = "compensation, block, form, work"
        lines = [*lines, "return y_new, k"]
    else:
        parameters = "block, form, work, rtol, atol"
        names["estimate"] = estimate
        lines.append("")
        for e in table.errors:
            lines += _comment(f"error = h ({_sum(e)})")
        lines.append("return y_new, k, estimate(place, h, k, y, y_new, rtol, atol)")
    return _compiled(name, f"step(rhs, t, y, h, k1, {parameters})", lines, names)


def write_dense_rows(name, table):
    """The `dense_rows` of a method; the work array holds the stages of the step."""
    n = len(table.b) + 1
    times, rows = table.extra
    stages, names = _stages(n + 1, times, rows)
    used = {j for row in (*rows, *table.d) for j, a in enumerate(row.exact[:n]) if a}
    lines = ["form = None", "place, y = slot(form, work, STAGE), slot(form, work, Y_OLD)"]
    lines += [f"k{j + 1} = slot(form, work, K + {j})" for j in sorted(used)]
    lines += stages
    for j, row in enumerate(table.d):
        names[f"D{j}"] = _without_zeros(row)
        lines += [
            "",
            *_comment(f"row {3 + j} = h ({_sum(row)})"),
            f"weigh(slot(form, d, F + {3 + j}), h, D{j}, {_stages_of(row)})",
        ]
    head = "dense_rows(rhs, t, h, work, block, d)"
    return _compiled(name, head, [*lines, f"return {len(rows)}"], names)
