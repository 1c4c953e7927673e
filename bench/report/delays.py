"""``python -m bench.report.delays``: the table of `docs/delays.md`, from its rows."""

from ..groups.delays import summary
from .table import put_group


def main():
    """Write it."""
    put_group("delays", summary, "delays.md")


if __name__ == "__main__":
    main()
