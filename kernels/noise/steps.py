"""One step of each method for dy = a(t, y) dt + G(t, y) dW: functions that write the step.

A step is ``step(t, y, k, h, noise, block, form, of_noise, work)``, and returns the state at t + h
and what the next step takes as `k`: the acceleration for Langevin's equation, nothing of use
elsewhere.  `noise` has the increments W of the step in row W and the areas in row H, see
`brownian.py`; the integral of W over the step is h (W / 2 + H).
"""

import numpy as np

from ..jit.options import INLINED, njit
from ..state.elementwise import apply, halves, join
from ..state.rows import fetch, slot
from .arguments import (
    DOWN,
    KEEPS,
    KICK,
    MEAN,
    OTHER_SLOPE,
    OUT,
    PRODUCT,
    SHARE,
    SLOPE,
    STAGE,
    UP,
    H,
    W,
)
from .diffusions import by_factor, noise_of


@njit(**INLINED)
def _moved(h, y, a):
    return (y + h * a,)


@njit(**INLINED)
def _moved_by_mean(h, y, a, b):
    return (y + 0.5 * h * (a + b),)


@njit(**INLINED)
def _half(w):
    return (0.5 * w,)


def euler_maruyama(functions):
    """y + a h + G W.

    Source: Maruyama, Continuous Markov processes and stochastic equations, Rend. Circ. Mat. Palermo
    4 (1955).  Order 0.5 on paths, 1 in moments.
    """
    drift = functions.drift
    spread = functions.spread

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        place = slot(form, work, OUT)
        a = drift(t, y, block, slot(form, work, SLOPE))
        moved = apply(_moved, (place,), (h,), (y, a))[0]
        moved = spread(place, moved, t, y, w, block, form, work)
        return moved, k

    return step


def heun(functions):
    """Heun's method, for Stratonovich's integral.

    Source: Rumelin, Numerical treatment of stochastic differential equations, SIAM J. Numer. Anal.
    19 (1982).  Order 0.5 on paths, 1 if the noise commutes.
    """
    drift = functions.drift
    spread = functions.spread

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        place = slot(form, work, OUT)
        a = drift(t, y, block, slot(form, work, SLOPE))
        stage = apply(_moved, (slot(form, work, STAGE),), (h,), (y, a))[0]
        stage = spread(slot(form, work, STAGE), stage, t, y, w, block, form, work)
        b = drift(t + h, stage, block, slot(form, work, OTHER_SLOPE))
        moved = apply(_moved_by_mean, (place,), (h,), (y, a, b))[0]
        half = apply(_half, (slot(of_noise, noise, SHARE),), (), (w,))[0]
        moved = spread(place, moved, t, y, half, block, form, work)
        moved = spread(place, moved, t + h, stage, half, block, form, work)
        return moved, k

    return step


@njit(**INLINED)
def _corrected(h, y, along, w):
    return (y + 0.5 * along * (w * w - h),)


def milstein(functions):
    """Euler and Maruyama's step with (g dg/dy) (W^2 - h) / 2 behind; h is 0 for Stratonovich's.

    Source: Milstein, Approximate integration of stochastic differential equations, Theory Probab.
    Appl. 19 (1974).  Order 1 on paths.  ``functions.along(t, y, block)`` gives g dg/dy.
    """
    drift = functions.drift
    diffusion = functions.diffusion
    along = functions.along
    spread = functions.spread
    one_source = functions.one_source
    ito = functions.ito

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        place = slot(form, work, OUT)
        a = drift(t, y, block, slot(form, work, SLOPE))
        moved = apply(_moved, (place,), (h,), (y, a))[0]
        moved = spread(place, moved, t, y, w, block, form, work)
        g = diffusion(t, y, block, slot(form, work, PRODUCT))
        product = along(t, y, g, block)
        taken = h if ito else 0.0
        if one_source:
            factor = 0.5 * (w[0] * w[0] - taken)
            return apply(by_factor, (place,), (factor,), (moved, product))[0], k
        return apply(_corrected, (place,), (taken,), (moved, product, w))[0], k

    return step


@njit(**INLINED)
def _mean_over_step(w, area):
    return (0.5 * w + area,)


@njit(**INLINED)
def _difference(w, mean):
    return (w - mean,)


@njit(**INLINED)
def _times(factor, x):
    return (factor * x,)


@njit(**INLINED)
def _moved_by_third(h, y, a, b):
    return (y + h * (a + 2.0 * b) / 3.0,)


def sra1(functions):
    """SRA1, for a G that depends on the time alone.

    Source: Rossler, Runge-Kutta methods for the strong approximation of solutions of stochastic
    differential equations, SIAM J. Numer. Anal. 48 (2010), table 6.3.  Order 1.5 on paths, 2 in
    moments.
    """
    drift = functions.drift
    spread = functions.spread

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        place = slot(form, work, OUT)
        share_place = slot(of_noise, noise, SHARE)
        w = noise_of(of_noise, noise, W)
        area = noise_of(of_noise, noise, H)
        mean = apply(_mean_over_step, (slot(of_noise, noise, MEAN),), (), (w, area))[0]
        a = drift(t, y, block, slot(form, work, SLOPE))
        stage = apply(_moved, (slot(form, work, STAGE),), (0.75 * h,), (y, a))[0]
        share = apply(_times, (share_place,), (1.5,), (mean,))[0]
        stage = spread(slot(form, work, STAGE), stage, t + h, y, share, block, form, work)
        b = drift(t + 0.75 * h, stage, block, slot(form, work, OTHER_SLOPE))
        moved = apply(_moved_by_third, (place,), (h,), (y, a, b))[0]
        share = apply(_difference, (share_place,), (), (w, mean))[0]
        moved = spread(place, moved, t + h, y, share, block, form, work)
        return spread(place, moved, t, y, mean, block, form, work), k

    return step


@njit(**INLINED)
def _weak_of_each(h, root, start, g, up, down, w):
    first = 0.25 * w
    second = 0.25 * ((w * w - h) / root)
    return (start + first * (up + down - 2.0 * g) + second * (up - down),)


@njit(**INLINED)
def _weak_of_one(first, second, start, g, up, down):
    return (start + first * (up + down - 2.0 * g) + second * (up - down),)


def platen(functions):
    """Platen's method of order 2 in moments, for noise whose components do not mix.

    Source: Kloeden, Platen, Numerical Solution of Stochastic Differential Equations (1992),
    equation (15.1.1).
    """
    drift = functions.drift
    diffusion = functions.diffusion
    spread = functions.spread
    one_source = functions.one_source

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        place = slot(form, work, OUT)
        stage_place = slot(form, work, STAGE)
        root = np.sqrt(h)
        a = drift(t, y, block, slot(form, work, SLOPE))
        g = diffusion(t, y, block, slot(form, work, PRODUCT))
        middle = apply(_moved, (place,), (h,), (y, a))[0]
        stage = apply(_moved, (stage_place,), (root,), (middle, g))[0]
        up = diffusion(t + h, stage, block, slot(form, work, UP))
        stage = apply(_moved, (stage_place,), (-root,), (middle, g))[0]
        down = diffusion(t + h, stage, block, slot(form, work, DOWN))
        stage = spread(stage_place, middle, t, y, w, block, form, work)
        b = drift(t + h, stage, block, slot(form, work, OTHER_SLOPE))
        moved = apply(_moved_by_mean, (place,), (h,), (y, a, b))[0]
        moved = spread(place, moved, t, y, w, block, form, work)
        if one_source:
            one = w[0]
            first = 0.25 * one
            second = 0.25 * ((one * one - h) / root)
            return apply(_weak_of_one, (place,), (first, second), (moved, g, up, down))[0], k
        return apply(_weak_of_each, (place,), (h, root), (moved, g, up, down, w))[0], k

    return step


@njit(**INLINED)
def _relaxed(factor, v, keeps, kick, x):
    return (keeps * v + factor * kick * x,)


ONE_UNIT = np.sqrt(12.0)  # the area H in units of W: of variance h instead of h / 12


def baoab(functions):
    """q'' = a(t, q) - friction q' + sigma dW/dt: half a kick, half a drift, friction and noise, ...

    Source: Leimkuhler, Matthews, Rational construction of stochastic numerical methods for
    molecular sampling, Appl. Math. Res. Express 2013, https://doi.org/10.1093/amrx/abs010.
    Positions in a harmonic well have their exact variance at any step.  `k` is the acceleration.
    """
    acceleration = functions.drift

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        q_place, v_place = halves(slot(form, work, OUT))
        keeps = halves(fetch(form, work, KEEPS))[0]
        kick = halves(fetch(form, work, KICK))[0]
        q, v = halves(y)
        v = apply(_moved, (v_place,), (0.5 * h,), (v, k))[0]
        q = apply(_moved, (q_place,), (0.5 * h,), (q, v))[0]
        v = apply(_relaxed, (v_place,), (1.0,), (v, keeps, kick, w))[0]
        q = apply(_moved, (q_place,), (0.5 * h,), (q, v))[0]
        k = acceleration(t + h, q, block, halves(slot(form, work, SLOPE))[0])
        v = apply(_moved, (v_place,), (0.5 * h,), (v, k))[0]
        return join(slot(form, work, OUT), q, v), k

    return step


def obabo(functions):
    """As `baoab`, with friction and noise in two halves at the ends of the step.

    Source: Bussi, Parrinello, Accurate sampling using Langevin dynamics, Phys. Rev. E 75, 056707
    (2007).  A step needs two independent noises: W, and H in units of W.
    """
    acceleration = functions.drift

    @njit(**INLINED)
    def step(t, y, k, h, noise, block, form, of_noise, work):
        w = noise_of(of_noise, noise, W)
        area = noise_of(of_noise, noise, H)
        q_place, v_place = halves(slot(form, work, OUT))
        keeps = halves(fetch(form, work, KEEPS))[0]
        kick = halves(fetch(form, work, KICK))[0]
        q, v = halves(y)
        v = apply(_relaxed, (v_place,), (1.0,), (v, keeps, kick, w))[0]
        v = apply(_moved, (v_place,), (0.5 * h,), (v, k))[0]
        q = apply(_moved, (q_place,), (h,), (q, v))[0]
        k = acceleration(t + h, q, block, halves(slot(form, work, SLOPE))[0])
        v = apply(_moved, (v_place,), (0.5 * h,), (v, k))[0]
        v = apply(_relaxed, (v_place,), (ONE_UNIT,), (v, keeps, kick, area))[0]
        return join(slot(form, work, OUT), q, v), k

    return step
