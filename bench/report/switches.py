"""``python -m bench.report.switches``: the table of `docs/events.md`, from its rows."""

import json

from ..groups.switches import summary
from .table import PAGE, RESULTS, put_in


def main():
    """Write it."""
    found = json.loads(RESULTS.with_name("switches.json").read_text())["switches"]
    begin, end = "<!-- switches: begin -->\n", "<!-- switches: end -->"
    put_in(PAGE.with_name("events.md"), begin, end, [summary(found)])


if __name__ == "__main__":
    main()
