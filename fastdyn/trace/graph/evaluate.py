"""The values of a graph at many points at once, computed by NumPy."""

from typing import Any

import numpy as np

from .expressions import live


def evaluate(graph, outputs, t, y, values, watch=(), under: Any = "ignore"):
    """Evaluate the outputs, and the nodes of `watch`, at k points.

    Parameters
    ----------
    t : ndarray, shape (k,)
    y : ndarray, shape (n, k)
    values : sequence of float
        The parameters, by slot.
    under : str
        What NumPy does if a number is too small for a float: "ignore" or "raise".

    Returns
    -------
    outputs : ndarray, shape (n_outputs, k)
    watched : ndarray, shape (n_watched, k)
    """
    found = {}
    with np.errstate(all="ignore", under=under):
        for node in live([*outputs, *watch]):
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
