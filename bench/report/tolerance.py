"""``python -m bench.report.tolerance``: the table of `docs/which_method.md`, from its rows."""

import json

from ..groups.tolerance import summary
from .table import PAGE, RESULTS, put_in


def main():
    """Write it."""
    found = json.loads(RESULTS.with_name("tolerance.json").read_text())["tolerance"]
    begin, end = "<!-- tolerance: begin -->\n", "<!-- tolerance: end -->"
    put_in(PAGE.with_name("which_method.md"), begin, end, [summary(found)])


if __name__ == "__main__":
    main()
