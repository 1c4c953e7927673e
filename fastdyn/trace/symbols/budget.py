"""Refuses large operations before their first node is made."""

from ..graph.expressions import MAX_NODES
from .symbolic import refuse


def check_operations(count):
    """Refuse an operation that takes more nodes than a graph may have."""
    if count > MAX_NODES:
        refuse("it takes too many operations", final=True, said=False)
