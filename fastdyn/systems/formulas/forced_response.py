"""One mode of a linear structure under a sine."""

import numpy as np


def forced_mode(t, natural, force, omega):
    """
    Solution of q'' + w² q = f sin(W t) from rest, and its rate; at resonance too.

    Parameters
    ----------
    t : ndarray
        Times, s.
    natural, omega : float
        Angular frequencies w and W, rad/s.
    force : float
        f, the force on a unit of mass.

    Returns
    -------
    tuple of ndarray
        q and q', of the shape of t.

    Notes
    -----
    q = f/(w² - W²) (sin W t - W/w sin w t), with the difference of the two sines taken apart so
    that nothing cancels where the frequencies meet.
    """
    beat, mean, total = 0.5 * (omega - natural), 0.5 * (omega + natural), omega + natural
    slow = t * np.sinc(beat * t / np.pi)  # sin(beat t) / beat
    q = force / total * (np.sin(natural * t) / natural - slow * np.cos(mean * t))
    rate = force * omega / total * slow * np.sin(mean * t)
    return q, rate
