"""``python -m bench.report.gradients``: the table of `docs/adjoint.md`, from its rows."""

import json

from ..groups.gradients import summary
from .table import PAGE, RESULTS, origin, put_in


def main():
    """Write it."""
    record = json.loads(RESULTS.with_name("gradients.json").read_text())
    begin, end = "<!-- gradients: begin -->\n", "<!-- gradients: end -->"
    lines = [summary(record["gradients"]), "", origin(record)]
    put_in(PAGE.with_name("adjoint.md"), begin, end, lines)


if __name__ == "__main__":
    main()
