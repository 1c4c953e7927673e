"""The motion of two bodies over a step of any length, in universal variables.

With beta = 2 mu/r0 - v0^2, eta = x0 . v0, zeta = mu - beta r0 and G_k = X^k c_k(beta X^2), the X of
a step h solves  r0 X + eta G_2 + zeta G_3 = h,  whose left side rises with X by the distance
r = r0 + eta G_1 + zeta G_2.  The state moves by

    x - x0 = f x0 + g v0        f = -mu G_2 / r0          g = h - mu G_3 = r0 G_1 + eta G_2
    v - v0 = f' x0 + g' v0      f' = -mu G_1 / (r0 r)     g' = -mu G_2 / r

for ellipses, parabolas and hyperbolas.  K. Stumpff, "Himmelsmechanik I", Berlin 1959; J. Wisdom and
D. M. Hernandez, "A fast and accurate universal Kepler solver without Stumpff series", MNRAS 453
(2015); H. Rein and D. Tamayo, "WHFast", MNRAS 452 (2015), whose equations (28) to (31) are the
above.
"""

import math
from fractions import Fraction

import numpy as np

from ...jit.options import INLINED, INTERNAL, njit
from ...state.layout import Form
from ...state.rows import keep_vector, vector_at
from ...vector.scalar_or_vector import any_lane, select

WIDTH = 4  # planets in a vector
FORM = Form(1, WIDTH)

# The largest |z| and the numbers of terms of series in lanes: the rest is below 2^-56.
SMALL = 0.1
N_FEW = 7
MIDDLE = 1.3
N_MORE = 10
LARGEST, N_TERMS = 10.0, 15  # half a revolution
EXACT = [[Fraction((-1) ** k, math.factorial(2 * k + i)) for k in range(N_TERMS)] for i in (2, 3)]
C2, C3 = (tuple(map(float, exact)) for exact in EXACT)
# The errors of these numbers would be the same in each step, and the energy would drift.
LOW2, LOW3 = (tuple(float(a - Fraction(float(a))) for a in exact) for exact in EXACT)
COARSE = 0.6  # (2 pi / 8)^2: fewer than eight steps of a revolution at this distance
CLOSE = 1e-6  # a change of X, as a share of X, whose cube is below rounding


def _series(n):
    @njit(**INLINED)
    def stumpff(z):
        """c_2(z) and c_3(z), for z of a few tenths."""
        c2 = C2[n - 1] * z + C2[n - 2]
        c3 = C3[n - 1] * z + C3[n - 2]
        for k in range(n - 3, 0, -1):
            c2 = (c2 * z + LOW2[k]) + C2[k]
            c3 = (c3 * z + LOW3[k]) + C3[k]
        return c2 * z + C2[0], (c3 * z + LOW3[0]) + C3[0]

    return stumpff


_long = _series(N_TERMS)
_more = _series(N_MORE)
_short = _series(N_FEW)


@njit(**INLINED)
def _in_lanes(z):
    if any_lane(abs(z) > SMALL):
        if any_lane(abs(z) > MIDDLE):
            return _long(z)
        return _more(z)
    return _short(z)


@njit(**INTERNAL)
def stumpff(z):
    """c_2(z) and c_3(z) for any z, by quartering."""
    n = 0
    while abs(z) > SMALL:
        z *= 0.25
        n += 1
    c2, c3 = _short(z)
    for _ in range(n):
        c0 = 1.0 - z * c2
        c1 = 1.0 - z * c3
        c2, c3, z = 0.5 * c1 * c1, 0.25 * (c2 + c0 * c3), 4.0 * z
    return c2, c3


@njit(**INTERNAL)
def solve_anywhere(h, r0, eta, zeta, beta):
    """The X of a step h > 0, by Newton's method between bounds that close in on X."""
    low = 0.0
    high = np.inf
    X = h / r0
    for _ in range(200):
        c2, c3 = stumpff(beta * X * X)
        G2 = X * X * c2
        G3 = X * X * X * c3
        r = r0 + eta * (X - beta * G3) + zeta * G2
        miss = r0 * X + eta * G2 + zeta * G3 - h
        if miss < 0.0:
            low = X
        else:  # or neither, where the hyperbolic functions overflow
            high = X
        middle = 2.0 * X if high == np.inf else 0.5 * (low + high)
        wanted = X - miss / r
        if miss > h or not low < wanted < high:  # far beyond X, steps of Newton's would be too many
            wanted = middle
        if abs(wanted - X) <= 2.0**-52 * X or (not low < middle < high and high < np.inf):
            return wanted
        X = wanted
    return X


@njit(**INTERNAL)
def of_any_step(x, y, z, vx, vy, vz, mu, h):
    """f, g, f' and g' of a step of any length and sign on any orbit."""
    sign = 1.0 if h >= 0.0 else -1.0
    r0 = math.sqrt(x * x + y * y + z * z)
    v2 = vx * vx + vy * vy + vz * vz
    eta = sign * (x * vx + y * vy + z * vz)
    zeta = v2 * r0 - mu
    beta = 2.0 * mu / r0 - v2
    left = abs(h)
    if beta > 0.0:
        period = 2.0 * math.pi * mu / (beta * math.sqrt(beta))
        left -= period * math.floor(left / period)
    if left == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    X = solve_anywhere(left, r0, eta, zeta, beta)
    c2, c3 = stumpff(beta * X * X)
    G2 = X * X * c2
    G3 = X * X * X * c3
    G1 = X - beta * G3
    r = r0 + eta * G1 + zeta * G2
    # With this g, an error of X is one of time: the state stays on its orbit.
    g = r0 * G1 + eta * G2
    fd = -mu * G1 / (r0 * r)
    f = -mu * G2 / r0
    gd = -mu * G2 / r
    if max(abs(1.0 + f), abs(1.0 + gd)) > 0.5:  # (1 + f) (1 + g') - g f' = 1
        if abs(1.0 + f) > abs(1.0 + gd):
            gd = (g * fd - f) / (1.0 + f)
        else:
            f = (g * fd - gd) / (1.0 + gd)
    return f, sign * g, sign * fd, gd


@njit(**INLINED)
def add_compensated(row, carries, at, change):
    """Add a vector to a row, with compensation of rounding errors."""
    high = vector_at(FORM, row, at)
    part = vector_at(FORM, carries, at) + change
    total = high + part
    keep_vector(FORM, row, at, total)
    keep_vector(FORM, carries, at, part - (total - high))


@njit(**INTERNAL)
def drift(x, v, x_carry, v_carry, mu, room, h, n, n_used):
    """Move n planets, a multiple of WIDTH, along their orbits.

    Parameters
    ----------
    x, v : row
        Positions and velocities: all first components, then all second, then all third.
    x_carry, v_carry : row
        Rounding errors of the sums, as x and v.
    mu : row
        n numbers, G times the mass that attracts each planet.
    room : row
        4 WIDTH numbers.
    h : float
        The step, of any length and sign.
    n, n_used : int
        The planets, and how many of them are not there to fill the lanes.

    Returns
    -------
    bool
        Whether the step is long for the motion at one of the distances: above COARSE.
    """
    coarse = False
    for i in range(0, n, WIDTH):
        x0 = vector_at(FORM, x, i)
        y0 = vector_at(FORM, x, n + i)
        z0 = vector_at(FORM, x, 2 * n + i)
        u0, v0, w0 = vector_at(FORM, v, i), vector_at(FORM, v, n + i), vector_at(FORM, v, 2 * n + i)
        m = vector_at(FORM, mu, i)
        r2 = x0 * x0 + y0 * y0 + z0 * z0
        r0 = np.sqrt(r2)
        ri = 1.0 / r0
        eta = x0 * u0 + y0 * v0 + z0 * w0
        v2 = u0 * u0 + v0 * v0 + w0 * w0
        beta, zeta = 2.0 * m * ri - v2, v2 * r0 - m
        tau = h * ri
        a, b = 0.5 * eta * ri, zeta * ri * (1.0 / 6.0)
        c = beta * a * (-1.0 / 12.0)
        X = tau - tau * tau * (a - tau * (2.0 * a * a - b + tau * (5.0 * a * (b - a * a) - c)))
        done = False
        G1, G2, G3, r = X, X, X, X
        for _ in range(6):
            X2 = X * X
            z = beta * X2
            if any_lane(~(abs(z) < LARGEST)):
                break
            c2, c3 = _in_lanes(z)
            G2, G3 = X2 * c2, X2 * X * c3
            G1, G0 = X - beta * G3, 1.0 - beta * G2
            miss = (r0 * X - h) + (eta * G2 + zeta * G3)
            r = r0 + (eta * G1 + zeta * G2)
            bend = eta * G0 + zeta * G1
            d = -2.0 * miss * r / (2.0 * r * r - miss * bend)  # Halley
            X = X + d
            if not any_lane(~(abs(d) < CLOSE * abs(X))):
                half = 0.5 * d
                G3 = G3 + d * (G2 + half * (G1 + d * (1.0 / 3.0) * G0))
                G2 = G2 + d * (G1 + half * G0)
                G1 = G1 + d * (G0 - half * beta * G1)
                r = r0 + (eta * G1 + zeta * G2)
                done = True
                break
        if done:
            per_r = 1.0 / r
            f, g = -m * ri * G2, h - m * G3
            fd = -m * ri * per_r * G1
            whole = 1.0 + f
            # (1 + f) (1 + g') - g f' = 1 keeps areas; rounding errors of g' would add up.
            gd = select(whole > 0.5, (g * fd - f) / whole, -m * per_r * G2)
        else:
            for k in range(i, min(i + WIDTH, n_used)):
                f1, g1, fd1, gd1 = of_any_step(
                    x[k], x[n + k], x[2 * n + k], v[k], v[n + k], v[2 * n + k], mu[k], h
                )
                room[k - i], room[WIDTH + k - i] = f1, g1
                room[2 * WIDTH + k - i], room[3 * WIDTH + k - i] = fd1, gd1
            f, g = vector_at(FORM, room, 0), vector_at(FORM, room, WIDTH)
            fd, gd = vector_at(FORM, room, 2 * WIDTH), vector_at(FORM, room, 3 * WIDTH)
        add_compensated(x, x_carry, i, f * x0 + g * u0)
        add_compensated(x, x_carry, n + i, f * y0 + g * v0)
        add_compensated(x, x_carry, 2 * n + i, f * z0 + g * w0)
        add_compensated(v, v_carry, i, fd * x0 + gd * u0)
        add_compensated(v, v_carry, n + i, fd * y0 + gd * v0)
        add_compensated(v, v_carry, 2 * n + i, fd * z0 + gd * w0)
        coarse = coarse or any_lane(m * (h * h) > COARSE * (r2 * r0))
    return coarse
