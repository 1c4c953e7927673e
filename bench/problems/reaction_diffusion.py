"""Reaction and diffusion by the method of lines, with many components: on a line and on a square.

End states are Radau's at rtol 1e-12, from which CVODE's at 1e-10 are less than 1e-7 away.
"""

import numpy as np

from .problem import large
from .stiff import Stiff, brusselator

DIFFUSION = 0.1


def brusselator_square_into(t, y, d):
    """E. Hairer and G. Wanner, section IV.10, but with no flux through the edges and no source.

    Concentrations of the two by turns, row by row.
    """
    m = round(np.sqrt(len(y) / 2))
    rate = DIFFUSION * (m - 1) ** 2
    for row in range(m):
        for column in range(m):
            k = 2 * (row * m + column)
            left, right = k - 2 if column > 0 else k, k + 2 if column < m - 1 else k
            below, above = k - 2 * m if row > 0 else k, k + 2 * m if row < m - 1 else k
            u, v = y[k], y[k + 1]
            spread_u = y[left] + y[right] + y[below] + y[above] - 4.0 * u
            spread_v = y[left + 1] + y[right + 1] + y[below + 1] + y[above + 1] - 4.0 * v
            d[k] = 1.0 + u * u * v - 4.4 * u + rate * spread_u
            d[k + 1] = 3.4 * u - u * u * v + rate * spread_v


def brusselator_square(m):
    """On m by m points, 2 m^2 components."""
    x = np.linspace(0.0, 1.0, m)
    y0 = np.empty((m, m, 2))
    y0[:, :, 0] = (22.0 * x * (1.0 - x) ** 1.5)[:, None]
    y0[:, :, 1] = (27.0 * x * (1.0 - x) ** 1.5)[None, :]
    name = f"Brusselator on a square, n = {2 * m * m}"
    problem = large(name, brusselator_square_into, 11.5, y0.reshape(-1), "")
    return Stiff(problem, 1.0, None, band=(2 * m, 2 * m))


LINES = (brusselator(2000), brusselator_square(20))
