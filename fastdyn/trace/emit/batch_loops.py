"""Emits the loops over the boxes of batches: stores, reductions, edges."""

import math

import numpy as np
from llvmlite import ir

from ..graph.refusal import Refusal
from .batch_values import BatchValues
from .memory import VECTOR, WIDTH
from .numbers import INDEX, REAL, WORD

IDENTITY = {"sum": 0.0, "top": -math.inf, "low": math.inf}


class BatchLoops(BatchValues):
    """Emits loops; `BatchEmitter` is the complete emitter."""

    def _box(self, formula):
        axes, shape = formula.merge_axes()
        wide = bool(axes) and shape[axes[-1]] >= WIDTH
        inner = axes[-1] if axes else None
        values: list = [None] * len(formula.values)
        depths: list = []
        for i, v in enumerate(formula.values):
            depths.append(max([_depth(v, axes), *[depths[a] for a in v.args]]))
            if depths[i] == 0:  # loop-invariant values are computed before the loops
                values[i] = self._value(v, values, self._one, None, ())
        self._loops(formula, axes, shape, wide, inner, values, depths, ())

    def _loops(self, formula, axes, shape, wide, inner, values, depths, ks):
        """Emit nested loops over `axes`; each loop computes the values of its depth."""
        if not axes:
            self._stores(formula, values, ks)
            return
        axis, *rest = axes
        depth = len(ks) + 1
        if rest:
            with self.each(WORD(shape[axis]), 1) as k:
                here, within = list(values), (*ks, (axis, k))
                self._make(formula, here, depths, depth, self._one, None, within)
                self._loops(formula, rest, shape, wide, inner, here, depths, within)
            return
        reduced = [s for s in formula.stores if s.reduction and not s.steps[axis]]
        totals = self._totals(reduced, wide)
        emitter, width = (self._wide, WIDTH) if wide else (self._one, 1)
        count = shape[axis]
        exact = any(s.reduction for s in formula.stores)  # each element counts only once
        whole = count - count % width if exact else count
        with self.each(WORD(whole), width) as k:
            here, within = list(values), (*ks, (axis, k))
            self._make(formula, here, depths, depth, emitter, inner, within)
            self._stores(formula, here, within, wide, reduced, totals)
        if whole < count:  # the remainder, shorter than a vector
            with self.each(WORD(count - whole), 1) as j:
                here, within = list(values), (*ks, (axis, self.builder.add(j, WORD(whole))))
                self._make(formula, here, depths, depth, self._one, None, within)
                self._stores(formula, here, within, False, reduced, totals)
        for store, (total, one) in zip(reduced, totals, strict=True):
            across, left = self._across(store.reduction, total), self.builder.load(one)
            self._combine_at(store, self._combined(store.reduction, across, left), ks)

    def _make(self, formula, values, depths, depth, emitter, inner, ks):
        for i, v in enumerate(formula.values):
            if depths[i] == depth:
                values[i] = self._value(v, values, emitter, inner, ks)

    def _stores(self, formula, values, ks, wide=False, reduced=(), totals=()):
        for store in formula.stores:
            value = self.number(values[store.value])
            if wide and not isinstance(value.type, ir.VectorType):
                value = self.splat(value)
            if store in reduced:
                self._add(store.reduction, totals[reduced.index(store)], value)
            elif store.reduction:
                self._combine_at(store, value, ks)
            else:
                self._put_at(store, value, ks)

    def _put_at(self, store, value, ks):
        axis = ks[-1][0] if ks else None
        place, target = self._place(store.place, store.steps, ks), self._array(store.target)
        if not self._spread(value, store, axis):
            self.put(value, target, place)
            return
        for lane in range(WIDTH):
            at = self.builder.add(place, WORD(lane * store.steps[axis]))
            self.put(self.builder.extract_element(value, INDEX(lane)), target, at)

    def _spread(self, value, store, axis):
        return isinstance(value.type, ir.VectorType) and store.steps[axis] != 1

    # -- reductions

    def _fill(self, root):
        target, value = self._at[root.target], REAL(IDENTITY[root.reduction])
        size = root.batch.size
        if size < WIDTH:
            for i in range(size):
                self.put(value, target, INDEX(i))
            return
        with self.each(WORD(size), WIDTH) as k:
            self.put(self.splat(value), target, k)

    def _totals(self, reduced, wide):
        """Allocate two accumulators for each reduction: a vector of partial results, a number."""
        found, b = [], self.builder
        with b.goto_entry_block():
            for _ in reduced:
                vector = b.alloca(VECTOR) if wide else None
                found.append((vector, b.alloca(REAL)))
        for store, (vector, one) in zip(reduced, found, strict=True):
            value = REAL(IDENTITY[store.reduction])
            if vector is not None:
                b.store(ir.Constant(VECTOR, [IDENTITY[store.reduction]] * WIDTH), vector)
            b.store(value, one)
        return found

    def _add(self, op, total, value):
        vector, one = total
        place = vector if isinstance(value.type, ir.VectorType) else one
        self.builder.store(self._combined(op, self.builder.load(place), value), place)

    def _across(self, op, vector):
        """Reduce the lanes of a vector to one number, in pairs."""
        b = self.builder
        if vector is None:
            return REAL(IDENTITY[op])
        value = b.load(vector)
        lanes = [b.extract_element(value, INDEX(i)) for i in range(WIDTH)]
        while len(lanes) > 1:
            half = len(lanes) // 2
            lanes = [self._combined(op, lanes[i], lanes[i + half]) for i in range(half)]
        return lanes[0]

    def _combined(self, op, a, b):
        if op == "sum":
            return self.builder.fadd(a, b)
        return self._one._intrinsic({"top": "llvm.maximum", "low": "llvm.minimum"}[op], [a, b])

    def _combine_at(self, store, value, ks):
        """Combine the stored element with a value, and store the result in its place."""
        b, axis = self.builder, ks[-1][0] if ks else None
        place, target = self._place(store.place, store.steps, ks), self._array(store.target)
        if isinstance(value.type, ir.VectorType):
            if store.steps[axis] != 1:
                raise Refusal("a reduction along strides", said=False)
            before = self.vector(target, place)
        else:
            before = b.load(b.gep(target, [place]))
        self.put(self._combined(store.reduction, before, value), target, place)

    # -- edges

    def _edges(self, formulas):
        """Emit one loop over all points of boxes with equal code; a table holds the places."""
        first = formulas[0]
        rows = np.concatenate([f.grid() for f in formulas]).astype(np.int32)
        reads = [i for i, v in enumerate(first.values) if v.kind == "read"]
        before: list = [None] * len(first.values)
        for i, v in enumerate(first.values):
            if v.kind == "one":
                before[i] = self._value(v, before, self._one, None, ())
        table = self.table(rows, INDEX)
        with self.each(WORD(len(rows)), 1) as r:
            places = self.row(table, r, rows.shape[1])
            values = list(before)
            for i, v in enumerate(first.values):
                if v.kind == "read":
                    values[i] = self._load(v.data[0], places[reads.index(i)])
                elif v.kind == "op":
                    values[i] = self._value(v, values, self._one, None, ())
            for store, place in zip(first.stores, places[len(reads) :], strict=True):
                self.put(values[store.value], self._array(store.target), place)


def _depth(v, axes):
    """The depth of the innermost loop in which a read varies; 0 for a value that is no read."""
    if v.kind in ("one", "op"):
        return 0
    return max((i + 1 for i, axis in enumerate(axes) if v.strides[axis]), default=0)
