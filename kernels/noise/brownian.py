"""Brownian motion as a function of seed, path, source and time, in constant memory.

Over an interval of length h, a source of noise has its increment W, of variance h, and its area
H = (integral of W(s) - s/h W(h)) / h, of variance h/12 and independent of W.  An interval of the
grid takes W and H from its number.  Halves of an interval take theirs from those of the whole and
two more numbers:

    W_1 - W_2 = 3 H + sqrt(h)/2 Z_1,   H_1 + H_2 = 2 H - (W_1 - W_2)/2,   H_1 - H_2 = sqrt(h/12) Z_2

so that steps of half the length follow the same path.  The rule follows from the covariances of W
and H, all normal; the area H is that of Foster, Lyons, Oberhauser, An optimal polynomial
approximation of Brownian motion, SIAM J. Numer. Anal. 58 (2020),
https://doi.org/10.1137/19M1261912.
"""

import numpy as np

from ..jit.options import INLINED, INTERNAL, njit
from ..random.normal import normals
from ..state.rows import keep_vector, numbers_of, vector_at
from .arguments import HALF, OF_H, OF_W, SOURCE_BITS, STACK, W_NEXT, H, W


@njit(**INLINED)
def _row(lanes, noise, row, source, width):
    return vector_at(lanes, numbers_of(noise), row * noise.shape[1] + source * width)


@njit(**INLINED)
def _keep(lanes, noise, row, source, width, value):
    keep_vector(lanes, numbers_of(noise), row * noise.shape[1] + source * width, value)


@njit(**INLINED)
def _of_grid(lanes, noise, run, path, interval, use, row, size, width):
    """Let `row` have the numbers of an interval: a pair serves an even interval and the next."""
    for source in range(noise.shape[1] // width):
        if interval & 1 and run.held == interval:
            value = _row(lanes, noise, row + W_NEXT - W, source, width)
        else:
            number = source + (use << SOURCE_BITS)
            even, odd = normals(lanes, run.key, path, interval >> 1, number)
            _keep(lanes, noise, row + W_NEXT - W, source, width, odd)
            value = odd if interval & 1 else even
        _keep(lanes, noise, row, source, width, size * value)


@njit(**INLINED)
def _halve(lanes, noise, run, path, level, node, width):
    """Replace W and H of an interval by those of its first half; keep those of the second."""
    h = run.interval * 0.5**level
    apart = 0.5 * np.sqrt(h)
    twist = np.sqrt(h / 12.0)
    for source in range(noise.shape[1] // width):
        number = source + ((HALF + level) << SOURCE_BITS)
        first, second = normals(lanes, run.key, path, node, number)
        w = _row(lanes, noise, W, source, width)
        area = _row(lanes, noise, H, source, width)
        difference = 3.0 * area + apart * first
        total = 2.0 * area - 0.5 * difference
        turn = twist * second
        _keep(lanes, noise, W, source, width, 0.5 * (w + difference))
        _keep(lanes, noise, H, source, width, 0.5 * (total + turn))
        _keep(lanes, noise, STACK + 2 * level, source, width, 0.5 * (w - difference))
        _keep(lanes, noise, STACK + 2 * level + 1, source, width, 0.5 * (total - turn))


@njit(**INLINED)
def _second_half(lanes, noise, level, width):
    """Let W and H be those of the second half of an interval of this level."""
    for source in range(noise.shape[1] // width):
        for row in range(2):
            kept = _row(lanes, noise, STACK + 2 * level + row, source, width)
            _keep(lanes, noise, W + row, source, width, kept)


@njit(**INTERNAL)
def draw(lanes, noise, run, path, i, areas, width):
    """Let the rows W, and H if `areas`, have the noise of step i for the paths from `path` on.

    `lanes` is the form of one vector of `width` lanes.  Steps come in order, from any step on;
    `run.held` is the interval whose numbers are in the rows W_NEXT and H_NEXT, -1 at first.
    """
    refine = run.refine
    interval = i >> refine
    part = i - (interval << refine)
    level = refine
    if part == 0 or run.held < 0:
        _of_grid(lanes, noise, run, path, interval, OF_W, W, np.sqrt(run.interval), width)
        if areas or refine > 0:
            size = np.sqrt(run.interval / 12.0)
            _of_grid(lanes, noise, run, path, interval, OF_H, H, size, width)
        run.held = interval + 1
        level = 0
    else:
        rest = part
        while rest & 1 == 0:
            rest >>= 1
            level -= 1
        _second_half(lanes, noise, level - 1, width)
    while level < refine:
        _halve(lanes, noise, run, path, level, i >> (refine - level), width)
        if (part >> (refine - level - 1)) & 1:
            _second_half(lanes, noise, level, width)
        level += 1
