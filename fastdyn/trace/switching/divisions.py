"""Divides spans at the times where expressions of the time switch: see `switches`."""

from typing import Any

import numpy as np

from ..graph.evaluate import evaluate
from ..graph.values import contents
from ..operations import OPERATIONS
from .decided import EPS, FAR, ROUNDINGS, Candidates, Parameters, weights
from .straight_lines import TooMany, compares

CONSTANT, AFFINE, MONOTONE, ANY = range(4)  # kinds of an expression between the divisions
MOST = 2**21  # divisions of a span, or of all spans
# Divisions that are looked at behind steps: four tables of a million knots take 1 s, else 26.
MOST_TOLD = 2**14
SAMPLES, MOST_SAMPLES, IN_ALL = 16, 1024, 2**14  # in an interval, the most there, in all intervals
HALVINGS = 54
# Numbers computed in one search, for each member, after which it is given up: 0.2 s.  An iteration
# that ends by a tolerance near rounding decides by noise, at as many times as are looked at.
MOST_WORK = 2**25
# Operations on arrays, however short, after which a search ends: 0.3 s.  Where a function looks for
# the nearest entry of a table, it decides as often as the table has entries, by formulas as long.
MOST_OPERATIONS = 2**16
# Samples that change their sign more often show rounding, of the residual of an iteration say, or
# an oscillation that they do not resolve.
NOISY = 0.25


class Divisions:
    """One search for at most `most` switching times, sorted by member and time.

    If it is not `sampled`, or took too long, those of expressions that are sampled are missing; if
    it took too many operations, those of the expressions that were left.
    """

    def __init__(self, switches, values, varying, first, last, count, most, sampled=True):
        self.of = switches
        self.first = first
        self.last = last
        self.count = count
        self._values = (values, varying)
        self._most = most
        self.off = ROUNDINGS * max(abs(t) for t in (first, last, 0.0) if abs(t) < FAR)
        self.member, self.t = np.empty(0, int), np.empty(0)
        self.weight = np.empty(0)  # of knots of smooth tables, in the sense of CHORD
        self.at_ends: list = []
        self._intervals: Any = None
        self._grids: dict = {}  # members, times and known values of the samples, by their number
        self._work = 0
        self._operations = 0
        self.partly = not sampled

    def value(self, node, member, t):
        """An expression at times of members."""
        if not len(t):
            return np.empty(0)
        given = Parameters(*self._values, member)
        found: dict = next((known for _, at, known in self._grids.values() if at is t), {})
        before = len(found)
        values = evaluate(self.of.graph, [node], t, (), given, found=found)[0][0]
        new = max(len(found) - before, 0)
        self._work += new * len(t)
        self._operations += new
        return values

    def found(self, end) -> Candidates:
        """The Candidates, which are all up to a time."""
        kinds: dict = {}
        with np.errstate(all="ignore"):
            for node in self.of.nodes:
                if self._operations > MOST_OPERATIONS:
                    self.partly = True
                    break
                kinds[node.key] = self._kind(node, [kinds.get(a.key, CONSTANT) for a in node.args])
        member, times = (
            map(np.array, zip(*sorted(set(self.at_ends)), strict=True))
            if (self.at_ends)
            else (np.empty(0, int), np.empty(0))
        )
        span = self.first, self.last
        return Candidates(
            self.member, self.t, self.weight, (member, times), span, end, False, self.count,
            self.partly,
        )  # fmt: skip

    # -- divisions

    @property
    def intervals(self):
        """Member, begin and end of each interval between two divisions."""
        if self._intervals is None:
            every = np.arange(self.count)
            member = np.r_[every, self.member, every]
            t = np.r_[np.full(self.count, self.first), self.t, np.full(self.count, self.last)]
            order = np.lexsort((t, member))
            member = member[order]
            t = t[order]
            same = member[1:] == member[:-1]
            self._intervals = member[1:][same], t[:-1][same], t[1:][same]
            self._grids.clear()
        return self._intervals

    def _divide(self, member, t, weight=None):
        """Add divisions; times that are equal to rounding become one."""
        weight = np.zeros(len(t)) if weight is None else weight
        near = (t - self.first <= self.off) | (self.last - t <= self.off)
        if near.any():
            at = np.clip(t[near], self.first, self.last)
            self.at_ends += zip(member[near].tolist(), at.tolist(), strict=True)
        new = [each[~near] for each in (member, t, weight)]
        if not len(new[0]):
            return
        old = self.member, self.t, self.weight
        member, t, weight = (np.r_[a, b] for a, b in zip(old, new, strict=True))
        order = np.lexsort((t, member))
        member = member[order]
        t = t[order]
        weight = weight[order]
        begins = np.r_[True, (np.diff(t) > self.off) | (np.diff(member) != 0)]
        at = np.flatnonzero(begins)
        self.member, self.t, self.weight = member[at], t[at], np.maximum.reduceat(weight, at)
        self._intervals = None
        if len(self.t) > self._most:
            raise TooMany(0.5 * (self.last - self.first))

    def _cross(self, of, kind, levels=None):
        """(member, time, index of the level) where ``of(member, t)`` crosses levels.

        `levels` are rising numbers; None stands for all whole numbers.
        """
        member, begin, end = self.intervals
        if kind == CONSTANT:
            return np.empty(0, int), np.empty(0), np.empty(0, int)
        length = end - begin
        if kind == AFFINE:
            short = np.minimum(length, 1e15 * np.maximum(1.0, np.abs(begin)))
            near = np.where(short < length, np.maximum(1.0, np.abs(begin)), 0.25 * length)
            x = begin + near
            dx = 2.0 * near
            one = of(member, x)
            other = of(member, x + dx)
            slope = (other - one) / dx
            ends = one - slope * near, one + slope * (end - x)
            slack = 8 * EPS * np.maximum(np.abs(one), np.abs(other))
            low = np.minimum(*ends) - slack
            high = np.maximum(*ends) + slack
            low[slope == 0.0] = np.nan
            j, k, level = self._between(low, high, levels, begin)
            member = member[j]
            t = x[j] + (level - one[j]) / slope[j]
            t += 1e-3 * (x[j] + near[j] - t)  # once more from nearby, for the last digits
            t += (level - of(member, t)) / slope[j]
            return member, np.clip(t, begin[j], end[j]), k
        at_ends = self._at_ends(of, levels)
        self.partly |= self._work > MOST_WORK * self.count
        if kind == ANY and self.partly:
            return tuple(map(np.concatenate, zip(*at_ends, strict=True)))
        owners, times = self._samples(kind)
        v = of(owners, times).reshape(len(begin), -1)
        t = times.reshape(v.shape)
        a, b, va, vb = (x.ravel() for x in (t[:, :-1], t[:, 1:], v[:, :-1], v[:, 1:]))
        member = np.repeat(member, v.shape[1] - 1)
        j, k, level = self._between(np.minimum(va, vb), np.maximum(va, vb), levels, a)
        if kind == ANY and levels is not None and len(levels) == 1 and len(j) > NOISY * len(a):
            j, k, level = j[:0], k[:0], level[:0]
        a = a[j]
        b = b[j]
        member = member[j]
        before = va[j] < level
        for _ in range(HALVINGS if len(j) else 0):
            middle = 0.5 * (a + b)
            same = (of(member, middle) < level) == before
            a = np.where(same, middle, a)
            b = np.where(same, b, middle)
        return tuple(map(np.concatenate, zip((member, b, k), *at_ends, strict=True)))

    def _samples(self, kind):
        """Members and times of samples in all intervals, n + 1 in each."""
        member, begin, end = self.intervals
        n = 1
        if kind == ANY:
            n = int(np.clip(IN_ALL // len(begin), SAMPLES, MOST_SAMPLES))
        if n not in self._grids:
            inside = np.linspace(1e-12, 1.0 - 1e-12, n + 1)
            t = begin[:, None] + (end - begin)[:, None] * inside
            self._grids[n] = np.repeat(member, n + 1), t.ravel(), {}
        return self._grids[n][:2]

    def _at_ends(self, of, levels):
        """(member, time, index of the level) of values at the ends of spans that are levels."""
        every = np.arange(self.count)
        for t in (self.first, self.last):
            v = of(every, np.full(self.count, t))
            k = np.round(v) if levels is None else np.searchsorted(levels, v).astype(float)
            known = np.isfinite(v)
            hit = known & (v == (k if levels is None else np.append(levels, np.nan)[k.astype(int)]))
            yield every[hit], np.full(int(hit.sum()), t), k[hit]

    def _between(self, low, high, levels, begin):
        """(interval, index of the level, level) of all levels in intervals of values."""
        good = np.isfinite(low) & np.isfinite(high)
        low = np.where(good, low, 1.0)
        high = np.where(good, high, 0.0)
        if levels is None:
            first = np.ceil(low)
            behind = np.floor(high) + 1.0
        else:
            first = np.searchsorted(levels, low, "left").astype(float)
            behind = np.searchsorted(levels, high, "right").astype(float)
        counts = np.maximum(behind - first, 0.0)
        total = counts.sum()
        if total > self._most:
            raise TooMany(self._length(counts, begin))
        counts = counts.astype(int)
        j = np.repeat(np.arange(len(counts)), counts)
        k = np.arange(len(j)) - np.repeat(np.cumsum(counts) - counts, counts)
        k = k + np.repeat(np.where(counts > 0, first, 0.0), counts)
        return j, k, k if levels is None else levels[k.astype(int)]

    def _length(self, counts, begin):
        """The length of a span with about half of `most` of the crossings in intervals."""
        whole = np.cumsum(counts)
        j = int(np.searchsorted(whole, self._most / 2))
        share = (self._most / 2 - (whole[j - 1] if j else 0.0)) / counts[j]
        end = begin[j + 1] if j + 1 < len(begin) else self.last
        return float(begin[j] + share * (end - begin[j]) - self.first)

    # -- operations

    def _of(self, *nodes, by=None):
        """The function of members and times that an expression is, or two expressions `by`."""

        def of(member, t):
            found = [self.value(node, member, t) for node in nodes]
            return found[0] if by is None else by(*found)

        return of

    def _kind(self, node, kinds):
        """Divide the span where an operation switches; return the kind between the divisions."""
        op = node.op
        args = node.args
        if op == "t":
            return AFFINE
        if compares(node):
            self._zeros(self._of(*args, by=np.subtract), _sum(*kinds))
            return CONSTANT
        if op in ("and", "or", "not"):
            return CONSTANT
        if op == "select":
            return max(kinds[1:])
        if op == "neg":
            return kinds[0]
        if op in ("add", "sub"):
            return _sum(*kinds)
        if op == "mul" and args[0] is args[1]:
            return self._even(node, kinds[0])
        if op == "mul":
            return max(kinds) if CONSTANT in kinds else ANY
        if op == "div":
            return self._quotient(node, kinds)
        if op == "abs":
            self._zeros(self._of(args[0]), kinds[0])
            return kinds[0]
        if op == "sqrt":
            return _of_monotone(kinds[0])
        if OPERATIONS[op].tables:
            return self._table(node, kinds[0])
        if OPERATIONS[op].whole:
            shift = 0.5 if op == "rint" else 0.0
            self._integers(self._of(args[0], by=lambda v: v + shift), kinds[0])
            return CONSTANT
        return self._call(node, kinds) if OPERATIONS[op].elementary else ANY

    def _zeros(self, of, kind):
        self._divide(*self._cross(of, kind, np.zeros(1))[:2])

    def _integers(self, of, kind):
        self._divide(*self._cross(of, kind)[:2])

    def _even(self, node, kind):
        """A square, or a power, or another function that turns where its operand is zero."""
        if kind != ANY:  # else the turns show no monotone pieces
            self._zeros(self._of(node.args[0]), kind)
        return _of_monotone(kind)

    def _quotient(self, node, kinds):
        if kinds[1] == CONSTANT:
            return kinds[0]
        self._zeros(self._of(node.args[1]), kinds[1])
        return _of_monotone(kinds[1]) if kinds[0] == CONSTANT else ANY

    def _table(self, node, kind):
        data = contents(node, self.of.graph.tables, self._values[0])
        if node.op == "table":
            self._integers(self._of(node.args[0]), kind)
            return CONSTANT
        knots, *rows = data if node.op != "search" else data[:1]
        knots = np.asarray(knots, float)
        member, t, k = self._cross(self._of(node.args[0]), kind, knots)
        degree = {"search": 0, "interpolate": 1}.get(node.op, len(rows) - 1)
        weight = None
        if degree > 1:
            heights = np.asarray(self.of.graph.compute(node, [knots], self._values[0]), float)
            weight = weigh(knots, heights)[k.astype(int)]
        self._divide(member, t, weight)
        if degree == 0:
            return CONSTANT
        return kind if degree == 1 else ANY

    def _call(self, node, kinds):
        name = node.op
        args = node.args
        if name == "fmod":
            kind = kinds[0] if kinds[1] == CONSTANT else ANY
            self._integers(self._of(*args, by=np.divide), kind)
            return kind
        if name in ("sin", "cos", "tan"):
            shift = 0.0 if name == "cos" else 0.5
            if kinds[0] != ANY or name == "tan":  # which has poles
                self._integers(self._of(args[0], by=lambda v: v / np.pi + shift), kinds[0])
            return _of_monotone(kinds[0])
        if name == "pow" and kinds[1] == CONSTANT:
            self._zeros(self._of(args[0]), kinds[0])  # also poles
            return _of_monotone(kinds[0])
        if OPERATIONS[name].parity == "even":
            return self._even(node, kinds[0])
        if name == "atan2":
            self._zeros(self._of(args[0]), kinds[0])
        return _of_monotone(kinds[0]) if OPERATIONS[name].monotone else ANY


def _sum(a, b):
    """The kind of a sum or a difference."""
    return max(a, b) if CONSTANT in (a, b) or a == b == AFFINE else ANY


def _of_monotone(kind):
    """The kind of a monotone function of an expression."""
    return kind if kind in (CONSTANT, ANY) else MONOTONE


def weigh(knots, heights):
    """The weights of the knots of a smooth table: see CHORD of `decided`."""
    return weights(_bends(knots, heights))


def _bends(knots, heights):
    """The change of the slope of the chords at each knot, as a share of the range."""
    length = np.diff(knots)
    slope = np.diff(heights) / length
    size = np.ptp(heights) or 1.0
    inner = np.abs(np.diff(slope)) * np.minimum(length[:-1], length[1:]) / size
    return np.r_[0.0, inner, 0.0]
