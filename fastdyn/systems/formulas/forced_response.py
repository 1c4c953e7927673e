"""One mode of a linear structure under a sine."""

import numpy as np


def forced_mode(t, natural, force, omega):
    """
    Solution q of q'' + w² q = f sin(W t) from rest, and its rate q'; at resonance too.

    `natural` and `omega` are the angular frequencies w and W, `force` is f, on a unit of mass.
    q = f/(w² - W²) (sin W t - W/w sin w t), with the difference of the two sines taken apart so
    that nothing cancels where the frequencies meet.
    """
    beat = 0.5 * (omega - natural)
    mean = 0.5 * (omega + natural)
    total = omega + natural
    slow = t * np.sinc(beat * t / np.pi)  # sin(beat t) / beat
    q = force / total * (np.sin(natural * t) / natural - slow * np.cos(mean * t))
    rate = force * omega / total * slow * np.sin(mean * t)
    return q, rate
