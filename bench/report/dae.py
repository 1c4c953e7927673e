"""``python -m bench.report.dae``: the table of F(t, y, y') = 0, from its rows."""

from ..groups.dae import summary
from .table import put_group


def main():
    """Write it."""
    put_group("dae", summary)


if __name__ == "__main__":
    main()
