"""Equations of motion, each written once for every solver.

A function of a namespace `m`, which has ``sqrt, sin, cos``, gives ``fun(t, w, *args)`` that returns
a tuple: with `math` it is Python that Numba compiles, with `heyoka` a formula, with `jax.numpy` a
traced function, with `numpy` one of extended precision.  Systems of many components have a second
text in loops, which writes into an array.
"""

import numpy as np


def satellite(m):
    """Point mass on a plane orbit: [x, y, vx, vy]."""

    def fun(t, w, GM):
        x, y, vx, vy = w
        r2 = x * x + y * y
        c = -GM / (r2 * m.sqrt(r2))
        return vx, vy, c * x, c * y

    return fun


def projectile(m):
    """Ball with quadratic drag: [x, y, z, vx, vy, vz]."""

    def fun(t, w, drag, g):
        _, _, _, vx, vy, vz = w
        s = drag * m.sqrt(vx * vx + vy * vy + vz * vz)
        return vx, vy, vz, -s * vx, -s * vy, -s * vz - g

    return fun


def pendulum(m):
    """Pendulum on a rod: [angle, its rate]."""

    def fun(t, w, g, length):
        theta, omega = w
        return omega, -(g / length) * m.sin(theta)

    return fun


def building(m):
    """Two floors over shaking ground: [y1, y2, v1, v2]."""

    def fun(t, w, k, mass, omega, d, L, g):
        y1, y2, v1, v2 = w
        s = d * m.sin(omega * t)
        lower, upper = 2.0 * k * (y1 - s - L), 2.0 * k * (y2 - y1 - L)
        return v1, v2, (upper - lower) / mass - g, -upper / mass - g

    return fun


def constrained_pendulum(m):
    """Pendulum in x and y, y downwards, the tension eliminated by hand: [x, y, vx, vy]."""

    def fun(t, w, g):
        x, y, vx, vy = w
        pull = (vx * vx + vy * vy + g * y) / (x * x + y * y)
        return vx, vy, -pull * x, g - pull * y

    return fun


def vehicle(m):
    """Car with a steering driver, the wheel forces eliminated by hand: [x, y, th, vx, vy, omega].

    The force on the front wheel acts along (dx, dy), that on the rear wheel included.
    """

    def fun(t, w, mass, L, c):
        _, _, th, vx, vy, omega = w
        alpha, turn, thrust = 0.1 + 0.2 * m.sin(t), 0.2 * m.cos(t), 0.2
        s, cs, sf, cf = m.sin(th), m.cos(th), m.sin(th + alpha), m.cos(th + alpha)
        sa, ca = m.sin(alpha), m.cos(alpha)
        v = m.sqrt(vx * vx + vy * vy)
        fx, fy = thrust * cs - c * v * vx, -thrust * s - c * v * vy
        rear = (s * vy - cs * vx) * omega
        front = (sf * vy - cf * vx) * (omega + turn) - 0.5 * L * sa * omega * turn
        dx, dy = sf + ca * s, cf + ca * cs
        force = (mass * (ca * rear + front) - dx * fx - dy * fy) / (dx * dx + dy * dy)
        ax, ay = (fx + force * dx) / mass, (fy + force * dy) / mass
        return vx, vy, omega, ax, ay, 2.0 / L * (rear - s * ax - cs * ay)

    return fun


def arenstorf(m):
    """Restricted three-body problem, rotating with earth and moon: [x, y, vx, vy]."""

    def fun(t, w, moon):
        x, y, vx, vy = w
        earth = 1.0 - moon
        r2, s2 = (x + moon) * (x + moon) + y * y, (x - earth) * (x - earth) + y * y
        a, b = earth / (r2 * m.sqrt(r2)), moon / (s2 * m.sqrt(s2))
        ax = x + 2.0 * vy - a * (x + moon) - b * (x - earth)
        return vx, vy, ax, y - 2.0 * vx - a * y - b * y

    return fun


def lorenz(m):
    """Lorenz's convection: [x, y, z]."""

    def fun(t, w, sigma, rho, beta):
        x, y, z = w
        return sigma * (y - x), x * (rho - z) - y, x * y - beta * z

    return fun


def henon_heiles(m):
    """Star in a galaxy's cubic potential: [x, y, vx, vy]."""

    def fun(t, w):
        x, y, vx, vy = w
        return vx, vy, -x - 2.0 * x * y, y * y - y - x * x

    return fun


def pleiades(m):
    """Seven stars of masses 1 to 7 in a plane: [x, y, vx, vy], seven of each; `m` has ``sum``."""

    def fun(t, w):
        x, y = w[:7], w[7:14]
        ax, ay = [[] for _ in range(7)], [[] for _ in range(7)]
        for i in range(7):
            for j in range(i):
                dx, dy = x[j] - x[i], y[j] - y[i]
                c = m.sum([dx * dx, dy * dy]) ** -1.5
                ax[i].append((j + 1.0) * (c * dx))
                ay[i].append((j + 1.0) * (c * dy))
                ax[j].append(-(i + 1.0) * (c * dx))
                ay[j].append(-(i + 1.0) * (c * dy))
        return (*w[14:], *map(m.sum, ax), *map(m.sum, ay))

    return fun


def pleiades_arrays(m):
    """`pleiades` as a function of whole arrays, for `jax.numpy`."""

    def fun(t, w):
        places = w[:14].reshape(2, 7)
        apart = places[:, None, :] - places[:, :, None]
        r2 = (apart * apart).sum(axis=0) + m.eye(7)
        pull = apart / (r2 * m.sqrt(r2)) @ m.arange(1.0, 8.0)
        return m.concatenate([w[14:], pull.ravel()])

    return fun


def pleiades_into(t, w, d):
    """`pleiades` in loops."""
    for i in range(14):
        d[i] = w[14 + i]
        d[14 + i] = 0.0
    for i in range(7):
        for j in range(i):
            dx, dy = w[j] - w[i], w[7 + j] - w[7 + i]
            r2 = dx * dx + dy * dy
            c = 1.0 / (r2 * np.sqrt(r2))
            d[14 + i] += (j + 1.0) * c * dx
            d[21 + i] += (j + 1.0) * c * dy
            d[14 + j] -= (i + 1.0) * c * dx
            d[21 + j] -= (i + 1.0) * c * dy


def chain_into(t, y, d):
    """Unit masses on unit springs between two walls: [q, v]."""
    n = y.size // 2
    d[:n] = y[n:]
    d[n] = y[1] - 2.0 * y[0]
    d[n + 1 : -1] = y[: n - 2] - 2.0 * y[1 : n - 1] + y[2:n]
    d[-1] = y[n - 2] - 2.0 * y[n - 1]


def chain_arrays(m):
    """`chain_into` as a function of whole arrays, for `jax.numpy`."""

    def fun(t, y):
        n = y.size // 2
        q = m.pad(y[:n], 1)
        return m.concatenate([y[n:], q[:-2] - 2.0 * q[1:-1] + q[2:]])

    return fun


SOFTENING = 0.01


def bodies_into(t, y, d):
    """n bodies of mass 1/n in space, attraction softened: [q, v], each x, y, z by body."""
    half = y.size // 2
    mass = 3.0 / half
    d[:half] = y[half:]
    d[half:] = 0.0
    for i in range(0, half, 3):
        for j in range(0, i, 3):
            dx, dy, dz = y[j] - y[i], y[j + 1] - y[i + 1], y[j + 2] - y[i + 2]
            r2 = dx * dx + dy * dy + dz * dz + SOFTENING * SOFTENING
            c = mass / (r2 * np.sqrt(r2))
            d[half + i] += c * dx
            d[half + i + 1] += c * dy
            d[half + i + 2] += c * dz
            d[half + j] -= c * dx
            d[half + j + 1] -= c * dy
            d[half + j + 2] -= c * dz


def bodies_arrays(m):
    """`bodies_into` as a function of whole arrays, for `jax.numpy`."""

    def fun(t, y):
        half = y.size // 2
        q = y[:half].reshape(-1, 3)
        apart = q[None, :, :] - q[:, None, :]
        r2 = (apart * apart).sum(axis=2) + SOFTENING * SOFTENING
        pull = (apart / (r2 * m.sqrt(r2))[:, :, None]).sum(axis=1) * (3.0 / half)
        return m.concatenate([y[half:], pull.ravel()])

    return fun
