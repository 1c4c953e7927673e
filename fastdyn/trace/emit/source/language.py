"""The languages of source text: how each writes numbers, declarations and calls.

An operation's form in a language is the field `c` or `js` of its record, a format in which {0},
{1} ... are the operands.  Other places in the format: {v}, the name of the result (the format is
then a whole statement); {length}, {count} and {tables}, the common length of tables, their number
without the first, and the tables; {side}, of a search; {n}, {scaled}, {transposed}, {data},
{first} and {args} of systems of linear equations.  What the
language lacks is a helper, a function of the texts `helpers.c` and `helpers.js`.
"""

import math
import re
from pathlib import Path
from typing import NamedTuple


class Language(NamedTuple):
    """A language of source text."""

    name: str
    field: str  # of the record of an operation; of the file of helpers, too
    number: str  # the declaration of a number
    truth: str  # the declaration of a truth value
    table: str  # the declaration of a table: {v}, {numbers}
    tables: str  # an array of tables: {names}
    call: str  # a function of the library: {name}, {args}
    infinite: str
    nan: str
    true: str
    false: str

    def constant(self, value):
        """A number or a truth value as text; a negative number in parentheses."""
        if isinstance(value, bool):
            return self.true if value else self.false
        if value != value:
            return self.nan
        text = self.infinite if math.isinf(value) else repr(abs(value))
        return f"(-{text})" if math.copysign(1.0, value) < 0.0 else text

    def form(self, record):
        """The format of an operation; None if the operation has no form in the language."""
        written = getattr(record, self.field)
        if written or written is None:
            return written
        if record.sign:
            return f"{{0}} {record.sign} {{1}}"
        return self.call.format(name=record.name) if record.elementary else None

    def helpers(self, text):
        """The helpers that a text calls, and the helpers of these, in the order of the file."""
        known = helpers_of(self.field)
        wanted = set()
        todo = [text]
        while todo:
            called = set(re.findall(r"\b\w+(?=\()", todo.pop())) & known.keys() - wanted
            wanted |= called
            todo += [known[name] for name in called]
        return [function for name, function in known.items() if name in wanted]


JAVASCRIPT = Language(
    "JavaScript", "js", number="const {v} = ", truth="const {v} = ",
    table="const {v} = [{numbers}];", tables="[{names}]", call="Math.{name}({{args}})",
    infinite="Infinity", nan="NaN", true="true", false="false",
)  # fmt: skip
C = Language(
    "C", "c", number="const double {v} = ", truth="const int {v} = ",
    table="static const double {v}[] = {{{numbers}}};",
    tables="(const double *const[]){{{names}}}", call="{name}({{args}})",
    infinite="INFINITY", nan="NAN", true="1", false="0",
)  # fmt: skip
LANGUAGES = {one.field: one for one in (C, JAVASCRIPT)}


def helpers_of(field):
    """The helpers of a language by name; a blank line separates two."""
    found = {}
    for text in Path(__file__).with_name(f"helpers.{field}").read_text().strip().split("\n\n"):
        signature = next(line for line in text.splitlines() if not line.startswith(("//", "/*")))
        found[re.findall(r"\w+(?=\()", signature)[0]] = text
    return found
