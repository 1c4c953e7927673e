"""Mechanisms of index 3, with constraints on their positions alone.

Car axis and Andrews' squeezing mechanism, with starts and reference solutions, are those of F.
Mazzia and C. Magherini, "Test Set for Initial Value Problem Solvers", release 2.4, 2008.
"""

import numpy as np


def pendulum(t, y, yp, length, g):
    x, z, u, v, force = y
    return [
        yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + g,
        x * x + z * z - length * length,
    ]  # fmt: skip


def from_angle(angle, speed, length, g):
    """All components of the pendulum."""
    s, c = np.sin(angle), np.cos(angle)
    force = speed**2 + g * c / length
    return np.array([length * s, -length * c, length * c * speed, length * s * speed, force])


def slider_crank(t, y, yp, r, length, m1, m2, m3, g):
    """Crank angle a, rod angle b, slider x; two closing conditions with their forces."""
    a, b, x, va, vb, vx, f1, f2 = y
    inertia = m1 * r * r / 3 + m2 * r * r
    c = m2 * r * length / 2
    return [
        yp[0] - va, yp[1] - vb, yp[2] - vx,
        inertia * yp[3] + c * np.cos(a - b) * yp[4] + c * np.sin(a - b) * vb**2
        + (m1 / 2 + m2) * g * r * np.cos(a) - f1 * r * np.sin(a) + f2 * r * np.cos(a),
        c * np.cos(a - b) * yp[3] + m2 * length**2 / 3 * yp[4] - c * np.sin(a - b) * va**2
        + m2 * g * length / 2 * np.cos(b) - f1 * length * np.sin(b) + f2 * length * np.cos(b),
        m3 * yp[5] - f1,
        r * np.cos(a) + length * np.cos(b) - x,
        r * np.sin(a) + length * np.sin(b),
    ]  # fmt: skip


CAR_AXIS_START = [0.0, 0.5, 1.0, 0.5, -0.5, 0.0, -0.5, 0.0, 0.0, 0.0]
CAR_AXIS_END = np.array([  # at t = 3
    0.493455784275402809122e-1, 0.496989460230171153861, 0.104174252488542151681e1,
    0.373911027265361256927, -0.770583684040972357970e-1, 0.744686658723778553466e-2,
    0.175568157537232222276e-1, 0.770341043779251976443, -0.473688659084893324729e-2,
    -0.110468033125734368808e-2,
])  # fmt: skip


def car_axis(t, y, yp):
    eps, mass, length, rest, r, w, g = 1e-2, 10.0, 1.0, 0.5, 0.1, 10.0, 1.0
    xl, yl, xr, yr, ul, vl, ur, vr, a, b = y
    yb = r * np.sin(w * t)
    xb = np.sqrt(length**2 - yb**2)
    left, right = np.hypot(xl, yl), np.hypot(xr - xb, yr - yb)
    k = mass * eps**2 / 2
    return [
        yp[0] - ul, yp[1] - vl, yp[2] - ur, yp[3] - vr,
        k * yp[4] - ((rest - left) * xl / left + a * xb + 2 * b * (xl - xr)),
        k * yp[5] - ((rest - left) * yl / left + a * yb + 2 * b * (yl - yr) - k * g),
        k * yp[6] - ((rest - right) * (xr - xb) / right - 2 * b * (xl - xr)),
        k * yp[7] - ((rest - right) * (yr - yb) / right - 2 * b * (yl - yr) - k * g),
        xb * xl + yb * yl,
        (xl - xr) ** 2 + (yl - yr) ** 2 - length**2,
    ]  # fmt: skip


ANDREWS_START = [
    -0.0617138900142764496358948458001, 0.0, 0.455279819163070380255912382449,
    0.222668390165885884674473185609, 0.487364979543842550225598953530,
    -0.222668390165885884674473185609, 1.23054744454982119249735015568, *[0.0] * 20,
]  # fmt: skip
ANDREWS_END = np.array([  # at t = 0.03: positions and velocities
    0.1581077119629904e2, -0.1575637105984298e2, 0.4082224013073101e-1, -0.5347301163226948,
    0.5244099658805304, 0.5347301163226948, 0.1048080741042263e1, 0.1139920302151208e4,
    -0.1424379294994111e4, 0.1103291221937134e2, 0.1929337464421385e2, 0.5735699284790808,
    -0.1929337464421385e2, 0.3231791658026955,
])  # fmt: skip


def andrews(t, y, yp):
    """Seven angles, their velocities and accelerations, and six forces."""
    q, v, w, forces = y[:7], y[7:14], y[14:21], y[21:]
    be, th, ga, ph, de, om, ep = q
    d, e, rr, ss, zf, zt, u = 28e-3, 2e-2, 7e-3, 35e-3, 2e-2, 4e-2, 4e-2
    (m11, m21, m22, m33, m44, m54, m55, m66, m76, m77), f = _of_bodies(q, v)
    gravity_of = [
        m11 * w[0] + m21 * w[1] - f[0], m21 * w[0] + m22 * w[1] - f[1], m33 * w[2] - f[2],
        m44 * w[3] + m54 * w[4] - f[3], m54 * w[3] + m55 * w[4] - f[4],
        m66 * w[5] + m76 * w[6] - f[5], m76 * w[5] + m77 * w[6] - f[6],
    ]  # fmt: skip
    bx, by = rr * np.cos(be) - d * np.cos(be + th), rr * np.sin(be) - d * np.sin(be + th)
    first = -rr * np.sin(be) + d * np.sin(be + th), d * np.sin(be + th)
    second = rr * np.cos(be) - d * np.cos(be + th), -d * np.cos(be + th)
    odd, even = forces[0] + forces[2] + forces[4], forces[1] + forces[3] + forces[5]
    by_forces = [
        first[0] * odd + second[0] * even,
        first[1] * odd + second[1] * even,
        -ss * np.cos(ga) * forces[0] - ss * np.sin(ga) * forces[1],
        -e * np.cos(ph + de) * forces[2] - e * np.sin(ph + de) * forces[3],
        (-e * np.cos(ph + de) + zt * np.sin(de)) * forces[2]
        + (-e * np.sin(ph + de) - zt * np.cos(de)) * forces[3],
        zf * np.sin(om + ep) * forces[4] - zf * np.cos(om + ep) * forces[5],
        (zf * np.sin(om + ep) - u * np.cos(ep)) * forces[4]
        + (-zf * np.cos(om + ep) - u * np.sin(ep)) * forces[5],
    ]
    xa, ya, xb, yb = -0.06934, -0.00227, -0.03635, 0.03273
    return [
        *[yp[i] - v[i] for i in range(7)],
        *[yp[7 + i] - w[i] for i in range(7)],
        *[gravity_of[i] + by_forces[i] for i in range(7)],
        bx - ss * np.sin(ga) - xb,
        by + ss * np.cos(ga) - yb,
        bx - e * np.sin(ph + de) - zt * np.cos(de) - xa,
        by + e * np.cos(ph + de) - zt * np.sin(de) - ya,
        bx - zf * np.cos(om + ep) - u * np.sin(ep) - xa,
        by - zf * np.sin(om + ep) + u * np.cos(ep) - ya,
    ]


def _of_bodies(q, v):
    """The elements of the mass matrix that are not zero, and the forces without constraints."""
    _, th, ga, ph, _, om, _ = q
    bep, thp, _, php, dep, omp, epp = v
    m1, m2, m3, m4, m5, m6, m7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
    i1, i2, i3, i4, i5, i6, i7 = 2.194e-6, 4.41e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5
    e, ea, da, rr, ra, l0 = 2e-2, 1421e-5, 115e-4, 7e-3, 92e-5, 7785e-5
    sa, sb, sc, sd, ta, tb = 1874e-5, 1043e-5, 18e-3, 2e-2, 2308e-5, 916e-5
    u, ua, ub, zf, zt, fa = 4e-2, 1228e-5, 449e-5, 2e-2, 4e-2, 1421e-5
    a, b = e - ea, zf - fa
    masses = (
        m1 * ra**2 + m2 * (rr**2 - 2 * da * rr * np.cos(th) + da**2) + i1 + i2,
        m2 * (da**2 - da * rr * np.cos(th)) + i2,
        m2 * da**2 + i2,
        m3 * (sa**2 + sb**2) + i3,
        m4 * a**2 + i4,
        m4 * (a**2 + zt * a * np.sin(ph)) + i4,
        m4 * (zt**2 + 2 * zt * a * np.sin(ph) + a**2) + m5 * (ta**2 + tb**2) + i4 + i5,
        m6 * b**2 + i6,
        m6 * (b**2 - u * b * np.sin(om)) + i6,
        m6 * (b**2 - 2 * u * b * np.sin(om) + u**2) + m7 * (ua**2 + ub**2) + i6 + i7,
    )
    dx = sd * np.cos(ga) + sc * np.sin(ga) - 0.03635 - 0.014
    dy = sd * np.sin(ga) - sc * np.cos(ga) + 0.03273 - 0.072
    pull = -4530.0 * (1 - l0 / np.sqrt(dx**2 + dy**2))
    forces = (
        0.033 - m2 * da * rr * thp * (thp + 2 * bep) * np.sin(th),
        m2 * da * rr * bep**2 * np.sin(th),
        pull * dx * (sc * np.cos(ga) - sd * np.sin(ga))
        + pull * dy * (sd * np.cos(ga) + sc * np.sin(ga)),
        m4 * zt * a * dep**2 * np.cos(ph),
        -m4 * zt * a * php * (php + 2 * dep) * np.cos(ph),
        -m6 * u * b * epp**2 * np.cos(om),
        m6 * u * b * omp * (omp + 2 * epp) * np.cos(om),
    )
    return masses, forces
