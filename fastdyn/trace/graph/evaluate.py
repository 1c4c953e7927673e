"""The values of a graph at many points at once, computed by NumPy."""

from typing import Any

import numpy as np

from .expressions import live

MOST_KNOWN = 2**22  # numbers: 32 MB


def evaluate(graph, outputs, t, y, values, watch=(), under: Any = "ignore", found=None):
    """Evaluate the outputs, and the nodes of `watch`, at k points.

    Parameters
    ----------
    t : ndarray, shape (k,)
    y : ndarray, shape (n, k)
    values : sequence of float
        The parameters, by slot.
    under : str
        What NumPy does if a number is too small for a float: "ignore" or "raise".
    found : dict, optional
        The values at these points that are known, by the keys of nodes, to which the others are
        added.  It is emptied where they are many.

    Returns
    -------
    outputs : ndarray, shape (n_outputs, k)
    watched : ndarray, shape (n_watched, k)
    """
    found = {} if found is None else found
    if len(found) * len(t) > MOST_KNOWN:
        found.clear()
    with np.errstate(all="ignore", under=under):
        for node in live([*outputs, *watch], found):
            if node.op == "const":
                value = node.data
            elif node.op == "par":
                value = np.float64(values[node.data])
            elif node.op == "t":
                value = t
            elif node.op == "y":
                value = y[node.data]
            else:
                value = graph.compute(node, [found[a.key] for a in node.args], values)
            found[node.key] = value
    k = len(t)
    rows = [[np.broadcast_to(found[a.key], k) for a in nodes] for nodes in (outputs, watch)]
    return np.array(rows[0], float).reshape(-1, k), np.array(rows[1]).reshape(-1, k)
