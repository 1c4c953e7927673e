"""``python -m bench.report.gradients``: the table of `docs/adjoint.md`, from its rows."""

from ..groups.gradients import summary
from .table import put_group


def main():
    """Write it."""
    put_group("gradients", summary, "adjoint.md")


if __name__ == "__main__":
    main()
