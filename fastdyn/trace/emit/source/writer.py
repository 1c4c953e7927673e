"""Writes the operations of a graph as statements of a language: the visitor over the records."""

import collections
import re
from typing import Any

import numpy as np

from ...graph.expressions import live
from ...graph.values import contents
from ...operations import OPERATIONS
from ...operations.linear import SCALED

LONGEST = 72  # letters of an expression that is written inside another, if nothing else needs it
ATOM = re.compile(r"[\w.]+(\[[\w.]+\])?|[\w.]+\([^()]*\)|\(-[\w.+-]+\)")
LEAVES = ("const", "t", "y", "par")


class Unwritable(ValueError):
    """The reason why a graph has no form in a language; `node` is the node that has none."""

    def __init__(self, why, node):
        super().__init__(why)
        self.node = node


class Writer:
    """Writes nodes of one graph.

    Parameters
    ----------
    language : Language
    graph : Graph
    parameter : callable
        ``parameter(slot)`` is the text of a parameter, or the number that it is.

    Attributes
    ----------
    lines : list of str
        The statements.
    tables : dict of str to str
        The declarations of the tables, by name.
    """

    def __init__(self, language, graph, parameter):
        self.language = language
        self.graph = graph
        self.parameter = parameter
        self.lines: list[str] = []
        self.tables: dict[str, str] = {}
        self._texts: dict[int, str] = {}
        self._uses: collections.Counter = collections.Counter()
        self._n = 0

    def nodes(self, outputs):
        """Write nodes and what they depend on; return their texts."""
        found = live(outputs)
        self._uses = collections.Counter(one.key for node in found for one in node.args)
        self._uses.update(node.key for node in outputs)
        for node in found:
            if node.key not in self._texts:
                self._texts[node.key] = self._text(node)
        return [self._texts[node.key] for node in outputs]

    def _text(self, node):
        if node.op == "const":
            return self.language.constant(node.data)
        if node.op == "t":
            return "t"
        if node.op == "y":
            return f"y[{node.data}]"
        if node.op == "par":
            found = self.parameter(node.data)
            return found if isinstance(found, str) else self.language.constant(found)
        operation = OPERATIONS[node.op]
        written = self.language.form(operation)
        if written is None:
            name = operation.words or node.op.replace("_", " ")
            raise Unwritable(f"{self.language.name} has no form of {name}", node)
        args = [self._texts[one.key] for one in node.args]
        if not re.fullmatch(r"\w+\({.*}\)", written):  # operands of a sign, not of a call
            args = [one if ATOM.fullmatch(one) else f"({one})" for one in args]
        places: dict[str, Any] = {"args": ", ".join(args)} | self._places(node, args)
        if "{v}" in written:
            name = self._new()
            self.lines.append(written.format(*args, v=name, **places))
            return name
        text = written.format(*args, **places)
        if self._uses[node.key] == 1 and len(text) <= LONGEST and not operation.inner:
            return text
        name = self._new()
        truth = self.graph.is_truth(node.key)
        declared = self.language.truth if truth else self.language.number
        self.lines.append(f"{declared.format(v=name)}{text};")
        return name

    def _new(self):
        self._n += 1
        return f"v{self._n}"

    def _places(self, node, args):
        """What the format of an operation on tables, or of linear equations, asks for."""
        data = node.data
        if OPERATIONS[node.op].tables:
            return self._read(node)
        if node.op == "factors":
            return {"n": data[0], "scaled": int(data[1] == SCALED)}
        if node.op == "singular":
            n, kind = node.args[0].data
            return {"n": n, "scaled": int(kind == SCALED)}
        if node.op == "solution":
            rest = {"first": args[0], "args": ", ".join(args[1:])}
            return rest | {"n": len(args) - 1, "transposed": int(bool(data))}
        return {"data": data}

    def _read(self, node):
        found = contents(node, self.graph.tables, np.asarray(self.graph.values))
        side = found[1] if node.op == "search" else ""
        rows = found[:1] if node.op == "search" else [found] if node.op == "table" else found
        names = [self._table(row) for row in rows]
        tables = self.language.tables.format(names=", ".join(names))
        return {"length": len(rows[0]), "count": len(rows) - 1, "tables": tables, "side": side}

    def _table(self, numbers):
        """The name of the table of some numbers, which is declared once."""
        words = ", ".join(self.language.constant(float(x)) for x in numbers)
        for name, declared in self.tables.items():
            if f"{{{words}}}" in declared or f"[{words}]" in declared:
                return name
        name = f"table_{len(self.tables) + 1}"
        self.tables[name] = self.language.table.format(v=name, numbers=words)
        return name
