"""``python -m bench.report.methods``: the facts of the methods, and their table in docs/methods.md.

Both are read from the files of the methods: see `kernels/methods/method.py`.
"""

import json
import pathlib

from fastdyn.kernels.methods import APART, COMPLEX, FILES, KEPT, METHODS, facts_in
from fastdyn.kernels.methods.method import Facts

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "methods.md"
BEGIN, END = "<!-- methods: begin -->\n", "<!-- methods: end -->"
DEFAULTS = Facts._field_defaults


def facts():
    """The text of `facts.json`: fields that differ from their defaults, a method a line."""
    lines = []
    for name, file in {**FILES, **APART}.items():
        found = [
            {k: v for k, v in one._asdict().items() if k not in DEFAULTS or v != DEFAULTS[k]}
            for one in facts_in(name, file)
        ]
        lines.append(f"{json.dumps(name)}: {json.dumps(found)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def table():
    """The table of all methods, as Markdown."""
    rows = [
        "| `method=` | order | order of the dense output | steps | equations | complex states |",
        "|---|---|---|---|---|---|",
    ]
    for name, m in METHODS.items():
        steps = "adaptive" if m.error_order else "constant"
        equations = "q'' = a(t, q)" if m.second_order else "y' = f(t, y)"
        equations += ", H = T(p) + V(q)" if m.separable else ""
        equations += ", M y' = f(t, y)" if m.takes_mass else ""
        on_pairs = "yes" if name in COMPLEX else "no"
        row = f'"{name}"`', m.order, m.dense_order, steps, equations, on_pairs
        rows.append(f"| `{' | '.join(map(str, row))} |")
    return "\n".join(rows) + "\n"


def main():
    """Write both."""
    KEPT.write_text(facts())
    text = PAGE.read_text()
    before, rest = text.split(BEGIN)
    PAGE.write_text(before + BEGIN + table() + END + rest.split(END, 1)[1])


if __name__ == "__main__":
    main()
