"""``python -m bench.report.hybrid``: the table of hybrid systems, from its rows."""

from ..groups.hybrid import summary
from .table import put_group


def main():
    """Write it."""
    put_group("hybrid", summary)


if __name__ == "__main__":
    main()
