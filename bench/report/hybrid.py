"""``python -m bench.report.hybrid``: the table of hybrid systems, from its rows."""

from ..groups.hybrid import summary
from .table import put_group

if __name__ == "__main__":
    put_group("hybrid", summary)
