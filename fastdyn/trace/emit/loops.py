"""Emits a plan as machine code: loops over boxes on vectors, loops over tables of edges."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
from llvmlite import ir

from ..graph.clock import look
from ..graph.refusal import Refusal
from .memory import VECTOR, WIDTH, Memory
from .numbers import BIT, INDEX, REAL, WORD, Emitter
from .plan import ALONE

IDENTITY = {"sum": 0.0, "top": -math.inf, "low": math.inf}


class Loops(Memory):
    """Emits a plan through an LLVM builder, at the start of a function.

    Parameters
    ----------
    builder : ir.IRBuilder
    plan : Plan
    source : object
        The source of an `Emitter`, which also has ``array(name)``, the address of an array.
    vector_function : callable
        ``function(name, values)`` emits an elementary function of vectors.
    sides : Sides, optional
        Emits the code that notes the outcomes of decisions.
    """

    def __init__(self, builder, plan, source, vector_function, sides=None):
        super().__init__(builder)
        self.plan = plan
        self.source = source
        self.sides = sides
        source.item = self._item
        source.address = self._address
        graph = plan.program.g
        self._one = Emitter(builder, graph, REAL, source)
        self._wide = Emitter(builder, graph, VECTOR, source, vector_function)
        self._at: dict = {}  # the addresses of arrays, by their names

    def store(self, out, adds=False):
        """Emit code that stores the results at `out`; return whether the function raises.

        With `adds`, the results are added to the numbers at `out`.
        """
        self._at["out"] = out
        places = {}
        total = 0
        for first, row in self.plan.kept.items():
            places[first], total = total, total + -(-row.size // WIDTH) * WIDTH
        with self.room(total) as room:
            gep = self.builder.gep
            self._at.update({first: gep(room, [WORD(at)]) for first, at in places.items()})
            self._in_loops(adds)
            return self._singly(out, adds)

    def _in_loops(self, adds):
        """Emit the boxes and edges."""
        if adds:
            for loop in self.plan.loops:
                for box in (*loop.alone, *(box for boxes in loop.alike for box in boxes)):
                    box.add_results()
        for loop in self.plan.loops:
            look()
            if loop.row is not None:
                getattr(self, f"_{loop.row.op}")(loop.row)
            for store in {s.target: s for box in loop.alone for s in box.stores}.values():
                if store.reduction and store.target != "out":
                    self._fill(store)
            for box in loop.alone:
                self._box(box)
            for boxes in loop.alike:
                self._edges(boxes)

    def _singly(self, out, adds):
        """Emit the results outside loops; return whether the function raises."""
        plan = self.plan
        b = self.builder
        node = plan.program.node
        *values, raises = self._one.nodes(
            [*[node(i) for _, i in plan.single], plan.program.raising]
        )
        for (place, _), value in zip(plan.single, values, strict=True):
            if adds:
                value = b.fadd(b.load(b.gep(out, [WORD(place)])), self.number(value))
            self.put(value, out, WORD(place))
        if self.sides is not None:
            for i, condition in enumerate(plan.single_decisions, len(plan.decisions)):
                self.sides.note(i, *self._one.nodes([condition]))
        return raises

    def _array(self, name):
        """The address of an array; see `Plan.array`."""
        if name is None:
            raise Refusal("a row is not in memory")
        if name in ("y", "block"):
            return self.source.array(name)
        if isinstance(name, tuple) and name[0] == "par":
            return self.source.table(name[1].start)
        if name not in self._at:  # an array of constants
            self._at[name] = self.table(self.plan.program.row_at(name[1]).data, REAL)
        return self._at[name]

    # -- rows with code of their own

    def _given(self, row):
        """The address of what a product reads."""
        return self._address(int(row.args[0][0]))

    def _address(self, i):
        """The address of a number of a row that is kept."""
        row = self.plan.program.row_at(i)
        return self.builder.gep(self._array(self.plan.array(row)), [WORD(i - row.first)])

    def _pack(self, row):
        nodes = [self.plan.program.node(i) for i in row.args[0].tolist()]
        for k, value in enumerate(self._one.nodes(nodes)):
            self.put(value, self._at[row.first], WORD(k))

    def _running(self, row):
        b = self.builder
        x = self._given(row)
        total = self._variable(REAL)
        b.store(REAL(0.0), total)
        with self.each(WORD(row.size), 1) as k:
            b.store(b.fadd(b.load(total), b.load(b.gep(x, [k]))), total)
            self.put(b.load(total), self._at[row.first], k)

    def _csr(self, row):
        b, x, total = self.builder, self._given(row), self._variable(REAL)
        begins, places, values = (self.source.table(s.start) for s in row.data[2:])
        whole = lambda at, k: b.fptosi(b.load(b.gep(at, [k])), WORD)  # noqa: E731
        with self.each(WORD(row.size), 1) as r:
            b.store(REAL(0.0), total)
            first = whole(begins, r)
            last = whole(begins, b.add(r, WORD(1)))
            some = b.icmp_signed("<", first, last)
            with b.if_then(some), self.each(b.sub(last, first), 1) as k:
                at = b.add(first, k)
                term = b.fmul(b.load(b.gep(values, [at])), b.load(b.gep(x, [whole(places, at)])))
                b.store(b.fadd(b.load(total), term), total)
            self.put(b.load(total), self._at[row.first], r)

    # -- boxes

    def _box(self, box):
        axes, shape = box.merge_axes()
        values: list = [None] * len(box.values)
        depths: list = []
        for v in box.values:  # the depth of the innermost loop in which a value varies
            own = [i + 1 for i, axis in enumerate(axes) if v.strides[axis] and v.kind != "op"]
            depths.append(max([0, *own[-1:], *[depths[a] for a in v.args]]))
        self._make(box, values, depths, 0, None, ())
        self._nest(box, axes, shape, values, depths, ())

    def _nest(self, box, axes, shape, values, depths, ks):
        """Emit nested loops over `axes`; each loop computes the values of its depth."""
        if not axes:
            self._stores(box, values, ks)
            return
        axis, *rest = axes
        count = shape[axis]
        depth = len(ks) + 1
        wide = not rest and count >= WIDTH
        reduced = [s for s in box.stores if s.reduction and not s.steps[axis] and not rest]
        kind = VECTOR if wide else REAL
        totals = [self._variable(kind) for _ in reduced]
        for store, total in zip(reduced, totals, strict=True):
            self.builder.store(_all(kind, IDENTITY[store.reduction]), total)

        def body(k, fresh=None):
            here = list(values)
            within = (*ks, (axis, k))
            self._make(box, here, depths, depth, axis if wide else None, within)
            if rest:
                self._nest(box, rest, shape, here, depths, within)
            else:
                self._stores(
                    box, here, within, wide, dict(zip(reduced, totals, strict=True)), fresh
                )

        left = count % WIDTH if wide and any(s.reduction == "sum" for s in box.stores) else 0
        with self.each(WORD(count - left), WIDTH if wide else 1) as k:
            body(k)
        if left:  # a sum takes each number once
            mask = ir.Constant(ir.VectorType(BIT, WIDTH), [i >= WIDTH - left for i in range(WIDTH)])
            body(WORD(count - WIDTH), mask)
        for store, total in zip(reduced, totals, strict=True):
            value = self._across(store.reduction, self.builder.load(total))
            self._put_at(store, value, ks)

    def _make(self, box, values, depths, depth, inner, ks):
        """Emit the values of a depth; with `inner`, on vectors along this axis."""
        for i, v in enumerate(box.values):
            if depths[i] == depth:
                values[i] = self._value(v, values, inner, ks)

    def _value(self, v, values, inner, ks):
        if v.kind == "one":
            return self._one.nodes([v.data])[0]
        if v.kind == "op":
            op, data = v.data
            given = [values[a] for a in v.args]
            if inner is not None:
                given = [self._as_vector(x) for x in given]
            if op == "copy":
                return given[0]
            if op == "select" and self.sides is not None:
                self.sides.note(data, given[0])
            if op in ALONE:
                raise Refusal("a row with code of its own is not in memory")  # then: one by one
            emitter = self._one if inner is None else self._wide
            return emitter.emit(SimpleNamespace(op=op, data=data), given)
        name, at, truth, *places = v.data
        place = self._place(at, v.strides, ks)
        array = self._array(name)
        if inner is None:
            return self._load(array, self._index(places, place), truth)
        step = v.strides[inner]
        if step == 1 and not places and array.type.pointee == REAL:
            return self.truth(truth, self.vector(array, place))
        lanes = [self.builder.add(place, WORD(lane * step)) for lane in range(WIDTH)]
        return self._vector_of([self._load(array, self._index(places, k), truth) for k in lanes])

    def _index(self, places, k):
        """The place in an array; with a table of places, the entry k of the table."""
        if not places:
            return k
        if id(places[0]) not in self._at:
            self._at[id(places[0])] = self.table(places[0].astype(np.int32), INDEX)
        b = self.builder
        return b.sext(b.load(b.gep(self._at[id(places[0])], [k])), WORD)

    def _load(self, array, place, truth):
        b = self.builder
        value = b.load(b.gep(array, [place]))
        if value.type != REAL:
            value = (b.sitofp if value.type == WORD else b.uitofp)(value, REAL)
        return self.truth(truth, value)

    def _item(self, i):
        """The value of one number of a row, outside loops."""
        values: list = []
        for v in self.plan.element(i).values:
            values.append(self._value(v, values, None, ()))
        return values[-1]

    def _place(self, at, strides, ks):
        b = self.builder
        place = WORD(at)
        for axis, k in ks:
            if strides[axis]:
                step = k if strides[axis] == 1 else b.mul(k, WORD(strides[axis]))
                place = b.add(place, step)
        return place

    def _as_vector(self, value):
        return value if isinstance(value.type, ir.VectorType) else self.splat(value)

    def _vector_of(self, found):
        result = ir.Constant(ir.VectorType(found[0].type, WIDTH), ir.Undefined)
        for lane, value in enumerate(found):
            result = self.builder.insert_element(result, value, INDEX(lane))
        return result

    # -- stores

    def _stores(self, box, values, ks, wide=False, totals=(), fresh=None):
        b = self.builder
        for store in box.stores:
            value = self.number(values[store.value])
            value = self._as_vector(value) if wide else value
            if store.reduction == "sum" and fresh is not None:
                value = b.select(fresh, value, _all(VECTOR, 0.0))
            if store in totals:
                total = totals[store]
                b.store(self._combined(store.reduction, b.load(total), value), total)
            else:
                self._put_at(store, value, ks)

    def _lanes(self, store, value, ks):
        """Pairs of a number and its place; a vector goes to one place if it is contiguous."""
        place = self._place(store.place, store.steps, ks)
        axis = ks[-1][0] if ks else None
        if not isinstance(value.type, ir.VectorType) or store.steps[axis] == 1:
            return [(value, place)]
        b = self.builder
        step = store.steps[axis]
        return [(b.extract_element(value, INDEX(lane)), b.add(place, WORD(lane * step)))
                for lane in range(WIDTH)]  # fmt: skip

    def _put_at(self, store, value, ks):
        """Store a value in its place; a reduction combines it with what is there."""
        b = self.builder
        array = self._array(store.target)
        for part, place in self._lanes(store, value, ks):
            if store.reduction:
                vector = isinstance(part.type, ir.VectorType)
                before = self.vector(array, place) if vector else b.load(b.gep(array, [place]))
                part = self._combined(store.reduction, before, part)
            self.put(part, array, place)

    def _fill(self, store):
        size = self.plan.kept[store.target].size
        value = REAL(IDENTITY[store.reduction])
        width = WIDTH if size >= WIDTH else 1
        with self.each(WORD(size), width) as k:
            self.put(self.splat(value) if width > 1 else value, self._at[store.target], k)

    def _variable(self, kind):
        with self.builder.goto_entry_block():
            return self.builder.alloca(kind)

    def _across(self, op, value):
        """Reduce the lanes of a vector to one number, in pairs."""
        if not isinstance(value.type, ir.VectorType):
            return value
        lanes: Any = [self.builder.extract_element(value, INDEX(i)) for i in range(WIDTH)]
        while len(lanes) > 1:
            half = len(lanes) // 2
            lanes = [self._combined(op, lanes[i], lanes[i + half]) for i in range(half)]
        return lanes[0]

    def _combined(self, op, a, b):
        if op == "sum":
            return self.builder.fadd(a, b)
        return self._one._intrinsic({"top": "llvm.maximum", "low": "llvm.minimum"}[op], [a, b])

    # -- edges

    def _edges(self, boxes):
        """Emit one loop over all points of boxes with equal code; a table holds the places."""
        first = boxes[0]
        rows = np.concatenate([box.grid() for box in boxes]).astype(np.int32)
        before: list = [None] * len(first.values)
        self._make(first, before, [v.kind != "one" for v in first.values], 0, None, ())
        table = self.table(rows, INDEX)
        with self.each(WORD(len(rows)), 1) as r:
            places = iter(self.row(table, r, rows.shape[1]))
            values = list(before)
            for i, v in enumerate(first.values):
                if v.kind == "read":
                    values[i] = self._load(self._array(v.data[0]), next(places), v.data[2])
                elif v.kind == "op":
                    values[i] = self._value(v, values, None, ())
            for store, place in zip(first.stores, places, strict=True):
                value = values[store.value]
                array = self._array(store.target)
                if store.reduction:
                    before = self.builder.load(self.builder.gep(array, [place]))
                    value = self._combined(store.reduction, before, self.number(value))
                self.put(value, array, place)


def _all(kind, value):
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)
