"""Stiff problems of physics: relaxation, waves on a grid, contact, an algebraic equation.

The Bloch equations and Schrödinger's on a grid are linear: their end states are those of the
matrix, by its eigenvectors.  The balls' is that at which Radau and DOP853 at rtol 1e-13 agree to
1e-9.  Robertson's problem as a DAE ends as the ODE does; its sum is right to 1e-16, which a finer
floor of the last component would ask IDA to see.
"""

import numpy as np
from scipy.linalg import eigh_tridiagonal

from .problem import Problem, large
from .stiff import END, Stiff

DETUNING, NUTATION = 1e3, 300.0  # rad / s
LONGITUDINAL, TRANSVERSE = 1.0, 1e5  # 1 / T1 and 1 / T2 in 1 / s


def bloch(t, y):
    """A driven and dephased spin in the rotating frame: F. Bloch, Phys. Rev. 70 (1946)."""
    x, z, w = y
    return [
        DETUNING * z - TRANSVERSE * x,
        -DETUNING * x - TRANSVERSE * z + NUTATION * w,
        -NUTATION * z - LONGITUDINAL * (w - 1.0),
    ]


def _bloch_end(t):
    """By eigenvectors about the state at rest; the start is [0, 0, 1]."""
    matrix = np.array([
        [-TRANSVERSE, DETUNING, 0.0],
        [-DETUNING, -TRANSVERSE, NUTATION],
        [0.0, -NUTATION, -LONGITUDINAL],
    ])  # fmt: skip
    rest = np.linalg.solve(matrix, [0.0, 0.0, -LONGITUDINAL])
    values, vectors = np.linalg.eig(matrix)
    shares = np.linalg.solve(vectors, [0.0, 0.0, 1.0] - rest)
    return (rest + vectors @ (np.exp(values * t) * shares)).real


WIDTH, DISPLACED = 8.0, 2.0  # of the grid, each side; of the state at the start


def schrodinger_into(t, y, d):
    """A harmonic oscillator, m = omega = hbar = 1, on a grid that ends at walls."""
    n = len(y)
    dx = 2.0 * WIDTH / (n + 1)
    for i in range(n):
        x = (i + 1) * dx - WIDTH
        left, right = (0.0 if i == 0 else y[i - 1]), (0.0 if i == n - 1 else y[i + 1])
        d[i] = 0.5j * (left - 2.0 * y[i] + right) / (dx * dx) - 0.5j * x * x * y[i]


def schrodinger(n, t_end):
    """A Gaussian that swings."""
    dx = 2.0 * WIDTH / (n + 1)
    x = np.arange(1, n + 1) * dx - WIDTH
    y0 = np.exp(-0.5 * (x - DISPLACED) ** 2) * (1.0 + 0.0j)
    values, vectors = eigh_tridiagonal(1.0 / dx**2 + 0.5 * x * x, np.full(n - 1, -0.5 / dx**2))
    end = vectors @ (np.exp(-1j * values * t_end) * (vectors.T @ y0))
    problem = large(f"Schrödinger, n = {n}", schrodinger_into, t_end, y0, "")
    return Stiff(problem, 1.0, end, band=(1, 1))


STIFFNESS, DAMPING = 1e7, 1.0  # N / m^1.5; s / m


def balls_into(t, y, d):
    """Balls of 1 kg and 0.1 m above each other and the floor: heights of lowest points, speeds.

    The contact force is Hertz's, its damping that of K. Hunt and F. Crossley, J. Appl. Mech. 42
    (1975).
    """
    n = len(y) // 2
    top, speed = 0.0, 0.0
    for i in range(n):
        d[i], d[n + i] = y[n + i], -9.81
        depth = top - y[i]
        if depth > 0.0:
            force = STIFFNESS * depth**1.5 * max(0.0, 1.0 + DAMPING * (speed - y[n + i]))
            d[n + i] += force
            if i > 0:
                d[n + i - 1] -= force
        top, speed = y[i] + 0.1, y[n + i]


def robertson_dae(t, y):
    """The sum of concentrations in place of the last equation."""
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, a + b + c - 1.0]


BALLS = [0.05, 0.2, 0.4, 0.65, 0.0, 0.0, 0.0, 0.0]
BALLS_END = [
    -0.80075685e-3, 0.098947158719, 0.21259507858, 0.3180804956,
    0.2138803493, -0.2537914897, -0.4395334993, -0.3903112562,
]  # fmt: skip
PHYSICS = (
    Stiff(
        Problem("Bloch", bloch, (0.0, 1.0), [0.0, 0.0, 1.0], ()), 1e-6, list(_bloch_end(1.0))
    ),
    schrodinger(200, 5.0),
    Stiff(large("four balls", balls_into, 0.4, BALLS, ""), 1e-3, BALLS_END),
    Stiff(
        Problem("Robertson, DAE", robertson_dae, (0.0, 1e11), [1.0, 0.0, 0.0], ()),
        np.array([1e-10, 1e-10, 1e-4]),
        END["Robertson"], mass=np.diag([1.0, 1.0, 0.0]),
    ),
)  # fmt: skip
