"""Files of exported functions: a header and a file in C, a module in JavaScript."""

import re
from typing import NamedTuple

from ...graph.derivatives import jacobian
from ...graph.refusal import Untraceable
from .functions import NotExported
from .language import LANGUAGES


class Named(NamedTuple):
    """A component of the state, or a parameter, as comments describe it."""

    name: str
    unit: str = ""
    meaning: str = ""
    value: float | None = None


class Code(NamedTuple):
    """What is exported.

    Parameters
    ----------
    name, title : str
    states, parameters : list of Named
    functions : dict of str to (Exported, str)
        The functions by name, with a description.
    jacobian : bool
        Whether the Jacobian of "rhs" is a function, too.
    """

    name: str
    title: str
    states: list
    parameters: list
    functions: dict
    jacobian: bool = False

    def texts(self, language, stem):
        """The texts of the files by the ends of their names; `stem` is the name without end."""
        named = re.sub(r"^(?=[0-9])|[^0-9A-Za-z_]", "_", self.name)
        parts = {
            f"{named}_{re.sub(r'[^0-9A-Za-z_]', '_', name)}" if language == "c" else name: part
            for name, part in self._written(language).items()
        }
        head = _comment([
            f"{self.title}, written by fastdyn.", "", *_described("y", self.states),
            *_described("p", self.parameters), *_promise(language),
        ])  # fmt: skip
        if language == "c":
            return _c(re.sub(r'[\\"\r\n]', "_", stem), named, head, parts)
        return _javascript(head, parts)

    def _written(self, language):
        """(Written, description, number of results) by name."""
        found = {}
        for name, (function, about) in self.functions.items():
            found[name] = function.written(language), about, len(function.outputs)
        if self.jacobian:
            function, _ = self.functions["rhs"]
            n = function.n
            try:
                rows, columns, nodes = jacobian(function.trace.graph, function.outputs, n)
            except Untraceable as reason:
                raise NotExported(f"`{self.name}` has no Jacobian: {reason}.") from None
            entries = [function.trace.graph.const(0.0)] * (n * n)
            for i, j, node in zip(rows.tolist(), columns.tolist(), nodes, strict=True):
                entries[i * n + j] = node
            about = "The Jacobian of rhs by y, row by row."
            found["jacobian"] = function.written(language, entries), about, n * n
        return found


def _described(letter, named):
    """Lines of a comment about states or parameters."""
    lines = []
    for i, one in enumerate(named):
        value = "" if one.value is None else f"{one.value!r}"
        words = [f"{letter}[{i}]", one.name, value, one.unit, one.meaning]
        lines.append("  ".join(word for word in words if word))
    return lines


def _promise(language):
    returns = ("0", "1") if language == "c" else ("false", "true")
    return [
        "", f"Each function writes to `out`, and returns {returns[0]}; where the Python function",
        f"raises an exception, each number in `out` is NaN, and the function returns {returns[1]}.",
        "`out` is another array than `y` and `p`.",
    ]  # fmt: skip


def _comment(lines):
    """Lines in a comment, which nothing in the lines can end."""
    safe = [re.sub(r"[\r\n\u2028\u2029]", " ", line).replace("*/", "* /") for line in lines]
    return "/*\n" + "".join(f" * {line}".rstrip() + "\n" for line in safe) + " */\n"


def statements(written, language, indent):
    """The statements of a function, with its results in `out`."""
    lines = list(written.lines)
    known = LANGUAGES[language]
    if written.raises:
        n = len(written.results)
        counter = "int" if language == "c" else "let"
        lines += [f"if ({written.raises}) {{", f"    for ({counter} i = 0; i < {n}; i++)",
                  f"        out[i] = {known.nan};", f"    return {known.true};", "}"]  # fmt: skip
    plus = "+" if language == "js" else ""  # of a truth value, a number
    for i, text in enumerate(written.results):
        value = text if not plus or not re.search(r"[<>=!&|]|true|false", text) else f"+({text})"
        lines.append(f"out[{i}] = {value};")
    lines.append(f"return {known.false};")
    return [indent + line for line in lines]


def _c(stem, named, head, parts):
    guard = f"{named.upper()}_H"
    signature = "int {}(double t, const double *y, const double *p, double *out)"
    header = [head, f"#ifndef {guard}", f"#define {guard}", ""]
    bodies = []
    for name, (written, about, n) in parts.items():
        header += [_comment([f"{about} {n} numbers."]).rstrip(), f"{signature.format(name)};", ""]
        unused = [f"    (void){word};" for word in ("t", "y", "p")]
        tables = [f"    {line}" for line in written.tables.values()]
        lines = [*tables, *statements(written, "c", "    ")]
        bodies += [signature.format(name), "{", *unused, *lines, "}", ""]
    header += [f"#endif /* {guard} */", ""]
    helpers = LANGUAGES["c"].helpers("\n".join(bodies))
    source = [head, f'#include "{stem}.h"', "", "#include <math.h>", ""]
    for one in helpers:
        source += [one, ""]
    return {".h": "\n".join(header), ".c": "\n".join([*source, *bodies])}


def _javascript(head, parts):
    bodies = []
    for name, (written, about, n) in parts.items():
        comment = _comment([f"{about} {n} numbers."]).rstrip()
        bodies += [comment, f"export {javascript(name, written)}", ""]
    helpers = LANGUAGES["js"].helpers("\n".join(bodies))
    return {".js": "\n".join([head, *[f"{one}\n" for one in helpers], *bodies])}


def javascript(name, written):
    """A function ``name(t, y, p, out)`` of JavaScript."""
    lines = [f"  {line}" for line in written.tables.values()]
    lines += statements(written, "js", "  ")
    return "\n".join([f"function {name}(t, y, p, out) {{", *lines, "}"])
