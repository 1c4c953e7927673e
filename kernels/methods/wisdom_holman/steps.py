"""The splitting of Wisdom and Holman: Kepler's orbits, and kicks by what perturbs them.

The coordinates are Jacobi's: planet i counts from the centre of mass of the star and of the planets
before it, eta_i is their mass with its own, and the attraction of G eta_i at this centre is its
Kepler orbit.  What is left perturbs: the pulls of the planets on each other, and the difference
between the star and the centre.  One step kicks, drifts along the orbits and kicks; the last kick
and the first of the next step are one.

J. Wisdom and M. Holman, Astron. J. 102 (1991).  The difference of two pulls is J. F. Encke's,
without cancellation: R. H. Battin, "An Introduction to the Mathematics and Methods of
Astrodynamics", section 8.4.  Perturbations a little ahead of the place take the error of second
order in the masses from order 2 in the step to order 4: J. Wisdom, M. Holman and J. Touma,
"Symplectic correctors", Fields Inst. Commun. 10 (1996); as two evaluations: H. Rein, D. Tamayo and
G. Brown, "High-order symplectic integrators for planetary dynamics and their implementation in
REBOUND", MNRAS 489 (2019).
"""

from typing import Any, NamedTuple

import numpy as np

from ...calls.calling_convention import call_kernel
from ...calls.user_function import words_at
from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import FINISHED, MEETING, NON_FINITE, RUNNING
from ...state.rows import keep_vector, vector_at
from ...stepping.fixed import LANDED
from ...vector.scalar_or_vector import any_lane
from .encounters import first_meeting
from .kepler import FORM, WIDTH, add_compensated, drift
from .vectors import combined, keep_three, three

# What the kernel notes and is told between its calls, apart from the state.
CALLS = np.dtype(
    [
        ("modified", "i8"),  # whether kicks are modified
        ("ahead", "f8"),  # the time from the last step to the output
        ("started", "i8"),  # whether the motion is started
        ("watched", "i8"),  # whether planets may meet in the next step
        ("n_coarse", "i8"),  # steps that were coarse
        ("met_at", "f8"),  # when two planets met, and their places in the state
        ("met", "i8"),
        ("met_by", "i8"),
    ]
)
# The block of a run: where to find `take_steps`, its words, and `n_steps` among these words.
KERNEL, WORDS, N_STEPS = range(3)
N_WORDS = 3

# Squared, on the safe side of (a + b)^2 <= 2 a^2 + 2 b^2, where a is the distance of a meeting and
# b half the way of two planets in a step, each not faster than 1.2 times what it is at the end.
NEAR = 2.0
WAY = 3.0
TOGETHER = 1.125  # as WAY, with the relative speed, not faster than 1.5 times what it is


class Motion(NamedTuple):
    """Places x and velocities v, with the rounding errors of their sums, and perturbations a."""

    x: Any
    v: Any
    x_carry: Any
    v_carry: Any
    a: Any


class Room(NamedTuple):
    """The memory of a run: rows for n planets, padded to a multiple p of WIDTH.

    Vectors are stored as all first components, all second, all third.  Matrices are stored by
    columns: the first index is the planet that others act on.
    """

    h: Any  # places from the star
    s: Any  # pulls of the star, per mass and G
    d: Any  # pulls of the other planets
    some: Any
    mu: Any  # G eta_i
    outer: Any  # G m_0 eta_i / eta_(i-1)
    inner: Any  # mu - outer
    centre: Any  # shares of the planets before in the centre from which a planet counts
    weights: Any  # G m_j, 0 for the planet itself
    apart: Any  # added to squared distances: very far for the planet itself, whose distance is 0
    near: Any  # squared distances of a meeting, per squared distance from the star
    of_pulls: Any  # the pulls on all planets as perturbations in Jacobi's coordinates
    of_star: Any
    masses: Any  # of the star and of the planets
    body: Any  # the place of each planet in the state
    drifting: Any  # place and velocity of the centre of all masses
    pairs: Any  # a and b of the corrector


def padded(n):
    """n as a multiple of WIDTH."""
    return -(-n // WIDTH) * WIDTH


@njit(**INLINED)
def _star_and_centre(x, a, m, n, p):
    """Write the places from the star, the pulls of the star, and what these perturb."""
    for i in range(0, p, WIDTH):
        x0, x1, x2 = three(x, i, p)
        c0, c1, c2 = combined(m.centre, x, (0, min(n, i + WIDTH)), i, p)
        h0, h1, h2 = x0 + c0, x1 + c1, x2 + c2
        rr = x0 * x0 + x1 * x1 + x2 * x2
        q = (c0 * (x0 + h0) + c1 * (x1 + h1) + c2 * (x2 + h2)) / rr  # h^2 = x^2 (1 + q)
        w = (1.0 + q) * np.sqrt(1.0 + q)
        rise = q * (3.0 + q * (3.0 + q)) / (1.0 + w)  # w - 1
        k = 1.0 / (rr * np.sqrt(rr))
        k_w = k / w
        outer, inner = vector_at(FORM, m.outer, i) * k_w, vector_at(FORM, m.inner, i) * k
        keep_three(
            a, i, p, outer * (rise * x0 - c0) + inner * x0, outer * (rise * x1 - c1) + inner * x1,
            outer * (rise * x2 - c2) + inner * x2,
        )  # fmt: skip
        keep_three(m.h, i, p, h0, h1, h2)
        keep_three(m.s, i, p, k_w * h0, k_w * h1, k_w * h2)


@njit(**INLINED)
def _pulls(v, way, m, n, p):
    """Write the pulls of the planets on each other; True if two may meet: see `perturb`."""
    h, close = m.h, False
    for i in range(0, p, WIDTH):
        h0, h1, h2 = three(h, i, p)
        hh = h0 * h0 + h1 * h1 + h2 * h2
        may = hh < 0.0
        if v is not None:
            v0, v1, v2 = three(v, i, p)
            there, hh = way * (v0 * v0 + v1 * v1 + v2 * v2), NEAR * hh
        d0, d1, d2 = 0.0 * h0, 0.0 * h0, 0.0 * h0
        for j in range(n):
            e0, e1, e2 = h[j] - h0, h[p + j] - h1, h[2 * p + j] - h2
            ee = (e0 * e0 + e1 * e1 + e2 * e2) + vector_at(FORM, m.apart, j * p + i)
            if v is not None:
                may = may | (ee < vector_at(FORM, m.near, j * p + i) * hh + there)
            pull = vector_at(FORM, m.weights, j * p + i) / (ee * np.sqrt(ee))
            d0, d1, d2 = d0 + pull * e0, d1 + pull * e1, d2 + pull * e2
        if v is not None:
            close = close or any_lane(may)
        keep_three(m.d, i, p, d0, d1, d2)
    return close


@njit(**INTERNAL)
def perturb(x, v, a, m, sizes, h):
    """Write the perturbations at x to a; `sizes` begin with n and p.

    True if two planets are so close that they may meet in a step h from here or to here, with the
    velocities v: seldom, so that a closer look costs little.  Without velocities, None, False.
    """
    n, p, _ = sizes
    if n == 1:
        return False
    _star_and_centre(x, a, m, n, p)
    close = _pulls(v, WAY * h * h, m, n, p)
    for i in range(0, p, WIDTH):
        u0, u1, u2 = combined(m.of_pulls, m.d, (0, min(n, i + WIDTH)), i, p)
        s0, s1, s2 = combined(m.of_star, m.s, (i, n), i, p)
        a0, a1, a2 = three(a, i, p)
        keep_three(a, i, p, a0 + (u0 + s0), a1 + (u1 + s1), a2 + (u2 + s2))
    return close


@njit(**INTERNAL)
def kick(z, h, p):
    for i in range(0, 3 * p, WIDTH):
        add_compensated(z.v, z.v_carry, i, h * vector_at(FORM, z.a, i))


@njit(**INTERNAL)
def move(z, m, h, n, p):
    """Move along the orbits; True if the step is coarse for one of them."""
    return drift(z.x, z.v, z.x_carry, z.v_carry, m.mu, m.some, h, p, n)


@njit(**INTERNAL)
def perturb_ahead(z, m, sizes, h, modified):
    """Write the perturbations of kicks of steps h; True as in `perturb`.

    They are those at h^2/12 times the perturbations ahead of x, where kicks are modified.
    """
    n, p, _ = sizes
    close = perturb(z.x, z.v, z.a, m, sizes, h)
    if modified != 0 and n > 1:
        for i in range(0, 3 * p, WIDTH):
            ahead = (h * h * (1.0 / 12.0)) * vector_at(FORM, z.a, i)
            keep_vector(FORM, m.some, i, vector_at(FORM, z.x, i) + ahead)
        perturb(m.some, None, z.a, m, sizes, 0.0)
    return close


@njit(**INTERNAL)
def correct(z, m, sizes, h, inverse):
    """The corrector of steps h, or its inverse; `sizes` are n, p and the number of pairs."""
    n, p, n_pairs = sizes
    ahead = 0.0
    for k in range(n_pairs):
        at = n_pairs - 1 - k if inverse else k
        step, size = m.pairs[2 * at] * (-h if inverse else h), m.pairs[2 * at + 1] * h
        move(z, m, ahead + step, n, p)
        for way in (1.0, -1.0):
            perturb(z.x, None, z.a, m, sizes, 0.0)
            kick(z, way * size, p)
            if way > 0.0:
                move(z, m, -2.0 * step, n, p)
        ahead = step
    if n_pairs > 0:
        move(z, m, ahead, n, p)


@njit(**INTERNAL)
def _copy(z, out, n):
    for row, copy in (
        (z.x, out.x),
        (z.v, out.v),
        (z.x_carry, out.x_carry),
        (z.v_carry, out.v_carry),
        (z.a, out.a),
    ):
        for i in range(n):
            copy[i] = row[i]


@njit(**INTERNAL)
def write_state(z, m, n, p, time, y):
    """Write the places and velocities of all bodies to the row y."""
    total = 0.0
    for i in range(n + 1):
        total += m.masses[i]
    for half in range(2):
        row = z.v if half else z.x
        for c in range(3):
            star = m.drifting[3 + c] if half else m.drifting[c] + time * m.drifting[3 + c]
            for i in range(n):
                place = row[c * p + i]
                for j in range(i):
                    place += m.centre[j * p + i] * row[c * p + j]
                m.some[i] = place
                star -= m.masses[i + 1] / total * place
            first = 3 * (n + 1) * half + c
            y[first] = star
            for i in range(n):
                y[first + 3 * int(m.body[i])] = star + m.some[i]


@njit(**INTERNAL)
def _may_meet(v, m, n, p, h):
    """`perturb`'s answer, again, with relative speeds: neighbours on circles are slow."""
    x, w = m.h, m.s
    for i in range(0, p, WIDTH):
        v0, v1, v2 = three(v, i, p)
        c0, c1, c2 = combined(m.centre, v, (0, min(n, i + WIDTH)), i, p)
        keep_three(w, i, p, v0 + c0, v1 + c1, v2 + c2)
    for i in range(0, p, WIDTH):
        (h0, h1, h2), (w0, w1, w2) = three(x, i, p), three(w, i, p)
        hh = NEAR * (h0 * h0 + h1 * h1 + h2 * h2)
        may = hh < 0.0
        for j in range(n):
            e0, e1, e2 = x[j] - h0, x[p + j] - h1, x[2 * p + j] - h2
            u0, u1, u2 = w[j] - w0, w[p + j] - w1, w[2 * p + j] - w2
            ee = (e0 * e0 + e1 * e1 + e2 * e2) + vector_at(FORM, m.apart, j * p + i)
            way = (TOGETHER * h * h) * (u0 * u0 + u1 * u1 + u2 * u2)
            may = may | (ee < vector_at(FORM, m.near, j * p + i) * hh + way)
        if any_lane(may):
            return True
    return False


@njit(**INTERNAL)
def look_ahead(z, m, sizes, h, modified):
    """A single step h of the corrected method."""
    n, p, _ = sizes
    correct(z, m, sizes, h, False)
    perturb_ahead(z, m, sizes, h, modified)
    kick(z, 0.5 * h, p)
    move(z, m, h, n, p)
    perturb_ahead(z, m, sizes, h, modified)
    kick(z, 0.5 * h, p)
    correct(z, m, sizes, h, True)


@njit(**INTERNAL)
def _met(start, end, m, sizes, calls, t, h, t_end):
    """Whether two planets meet in a step h from t, not behind the end; writes when and which."""
    n, p, _ = sizes
    share, i, j = first_meeting(start, end, m, n, p, h)
    time = t + share * h
    if not share <= 1.0 or (time - t_end) * h > 0.0:
        return False
    calls.met_at = time
    calls.met = int(m.body[i])
    calls.met_by = int(m.body[j])
    return True


@njit(**INTERNAL)
def take_steps(state, record, z, out, m, y, n_steps):
    """Take at most `n_steps` steps; y then is the motion `ahead` of the time, by a shorter step.

    `record` is one record of CALLS, `z` the Motion of the last step, `out` that of an output, `m`
    the Room.  The first call starts from `out`: corrected, and half a kick ahead, where the
    motion stays.  What is computed for an output is thrown away.  A meeting ends the run with the
    step in which it is, and an output within this step is not computed.
    """
    s = state[0]
    calls = record[0]
    h = s.direction * s.h
    n = len(m.body)
    p = len(m.mu)
    of = (n, p, len(m.pairs) // 2)
    modified = calls.modified
    status = RUNNING
    t = s.t
    t_old = s.t_old
    taken = 0
    if calls.started == 0:
        correct(out, m, of, h, False)
        close = perturb_ahead(out, m, of, h, modified) and _may_meet(out.v, m, n, p, h)
        if close and _met(out, out, m, of, calls, t, 0.0, s.t_end):
            return MEETING
        calls.watched = close
        kick(out, 0.5 * h, p)
        _copy(out, z, 3 * p)
        calls.started = 1
    if n_steps > 0 and s.direction * (t - s.t_end) >= 0.0:
        return FINISHED
    watched = calls.watched != 0
    while taken < n_steps and status == RUNNING:
        if move(z, m, h, n, p):
            calls.n_coarse += 1
        close = perturb_ahead(z, m, of, h, modified) and _may_meet(z.v, m, n, p, h)
        if close or watched:
            _copy(z, out, 3 * p)
            move(out, m, -h, n, p)
            if _met(out, z, m, of, calls, t, h, s.t_end):
                status = MEETING
        watched = close
        if n > 1:
            kick(z, h, p)
        taken += 1
        t_old = t
        t = s.t_start + (s.n_accepted + taken) * h
        if abs(t - s.t_end) <= LANDED * s.h:
            t = s.t_end
        if status == RUNNING and s.direction * (t - s.t_end) >= 0.0:
            status = FINISHED
    s.t = t
    s.t_old = t_old
    s.n_accepted += taken
    calls.watched = watched
    ahead = calls.ahead
    _copy(z, out, 3 * p)
    if ahead != 0.0 and n > 1 and status != MEETING:
        move(out, m, h, n, p)
        if _met(z, out, m, of, calls, t, h, s.t_end):
            status = MEETING
        _copy(z, out, 3 * p)
    if status == MEETING:
        return MEETING
    kick(out, -0.5 * h, p)
    correct(out, m, of, h, True)
    if ahead != 0.0:
        look_ahead(out, m, of, ahead, modified)
    write_state(out, m, n, p, s.n_accepted * h + ahead, y)
    size = 0.0
    for i in range(len(y)):
        size += abs(y[i])
    return status if size < np.inf else NON_FINITE


@njit(**INTERNAL)
def advance(state, work, block, n_steps):
    """`take_steps` in the form of other kernels, for loops over steps of any method."""
    words_at(block[WORDS])[block[N_STEPS]] = n_steps
    return call_kernel(block[KERNEL], block[WORDS])
