"""``python -m bench.report.dae``: the table of F(t, y, y') = 0, from its rows."""

import json

from ..groups.dae import table
from .table import PAGE, RESULTS, origin, put_in

BEGIN, END = "<!-- dae: begin -->\n", "<!-- dae: end -->"


def main():
    """Write the table."""
    record = json.loads(RESULTS.with_name("dae.json").read_text())
    put_in(PAGE, BEGIN, END, ["Microseconds:", "", *table(record["dae"]), "", origin(record)])


if __name__ == "__main__":
    main()
