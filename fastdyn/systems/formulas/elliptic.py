"""Motions of the pendulum in Jacobi's elliptic functions, accurate up to the separatrix."""

import numpy as np


def swinging(phase, k, beyond):
    """
    Motion of a pendulum that turns back before the top, launched at the bottom: (angle, rate).

    `phase` is the time multiplied by the natural frequency, and the rate is the derivative with
    respect to it; `k` is the modulus, launch velocity divided by 2 sqrt(g l); `beyond` is k² - 1,
    to its own relative accuracy.
    """
    phi = amplitude(phase, -beyond)
    dn = np.sqrt(np.cos(phi) ** 2 - beyond * np.sin(phi) ** 2)
    return 2.0 * np.arctan2(k * np.sin(phi), dn), 2.0 * k * np.cos(phi)


def separatrix(phase, k, beyond):
    """Motion that comes to rest at the top after an infinite time; as `swinging`."""
    decay = np.exp(-np.abs(phase))
    return 4.0 * np.arctan(np.tanh(0.5 * phase)), 4.0 * decay / (1.0 + decay**2)


def whirling(phase, k, beyond):
    """Motion over the top, turn after turn; as `swinging`, the angle not wrapped."""
    m1 = beyond / k**2
    phi = amplitude(k * phase, m1)
    return 2.0 * phi, 2.0 * k * np.sqrt(np.cos(phi) ** 2 + m1 * np.sin(phi) ** 2)


def first_passage(half_angle, k):
    """Phase, as of `swinging`, at which twice `half_angle` >= 0 is first passed; NaN if never."""
    from scipy.special import ellipkinc  # takes longer to import than the rest of fastdyn

    if k > 1.0:
        return float(ellipkinc(half_angle, 1.0 / k**2)) / k
    if half_angle > 0.5 * np.pi or np.sin(half_angle) > k:
        return np.nan
    return float(ellipkinc(np.arcsin(np.sin(half_angle) / k), k**2)) if half_angle else 0.0


def phase_at(half_angle, rate, k, beyond):
    """
    Phase, as of `swinging`, at which a motion has half an angle and half a rate >= 0.

    The angle is less than pi in size unless the motion is over the top; both belong to `k`.
    """
    from scipy.special import ellipkinc

    sine = np.sin(half_angle)
    if beyond > 0.0:
        return float(ellipkinc(half_angle, 1.0 / k**2)) / k
    if beyond == 0.0:
        return float(np.arcsinh(np.tan(half_angle)))
    if rate == 0.0:
        return float(np.sign(sine)) * quarter_period(-beyond)
    return float(ellipkinc(np.arctan2(sine, rate), k**2))


def quarter_period(m1):
    """Complete elliptic integral K(1 - m1), from the complement m1 of the parameter."""
    means, _ = _means(m1)
    return np.pi / (2.0 * means[-1])


def amplitude(u, m1):
    """
    Jacobi's amplitude phi = am(u | m = 1 - m1), not wrapped, for 0 < m1 <= 1.

    sn = sin phi, cn = cos phi, dn = sqrt(cos² phi + m1 sin² phi).

    Descending Landen transformation by the arithmetic-geometric mean (Abramowitz and Stegun
    16.4). ``scipy.special.ellipj`` takes m instead of m1 and loses the digits that 1 - m loses:
    at m = 1 - 1e-9, ten periods out, it is wrong by 1e-8, and beyond 1 - 1e-10 it is a series for
    small u alone. Here each arcsine is taken as an arctangent, which keeps full accuracy.
    """
    means, other = _means(m1)
    half_turns = np.round(np.asarray(u, float) * means[-1] / np.pi)
    rest = np.asarray(u, float) - half_turns * (np.pi / means[-1])
    phi = 2.0 ** (len(means) - 1) * means[-1] * rest
    for n in range(len(means) - 1, 0, -1):
        c = 0.5 * (means[n - 1] - other[n - 1])
        sine = np.sin(phi)
        cosine = np.cos(phi)
        phi = 0.5 * (phi + np.arctan2(c * sine, np.hypot(means[n] * cosine, other[n] * sine)))
    return phi + np.pi * half_turns


def _means(m1):
    """Arithmetic and geometric means, down to their common limit."""
    means = [1.0]
    other = [float(np.sqrt(m1))]
    while means[-1] - other[-1] > 1e-9 * means[-1] or len(means) < 2:
        a = means[-1]
        b = other[-1]
        means.append(0.5 * (a + b))
        other.append(float(np.sqrt(a * b)))
    a = means[-1]
    b = other[-1]
    return [*means, 0.5 * (a + b)], [*other, float(np.sqrt(a * b))]
