"""``python -m bench.report.hybrid``: the table of hybrid systems, from its rows."""

import json

from ..groups.hybrid import table
from .table import PAGE, RESULTS, origin, put_in

BEGIN, END = "<!-- hybrid: begin -->\n", "<!-- hybrid: end -->"


def main():
    """Write the table."""
    record = json.loads(RESULTS.with_name("hybrid.json").read_text())
    put_in(PAGE, BEGIN, END, ["Microseconds:", "", *table(record["hybrid"]), "", origin(record)])


if __name__ == "__main__":
    main()
