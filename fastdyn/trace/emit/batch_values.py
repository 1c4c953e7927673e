"""Emits the values of batch formulas: reads from memory, operations, single nodes."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from llvmlite import ir

from ..batches.boxes import formula_of_one, name_of
from .memory import VECTOR, WIDTH, Memory
from .numbers import INDEX, REAL, WORD, Emitter


class BatchValues(Memory):
    """Emits values for the loops of `BatchLoops`; `BatchEmitter` is the complete emitter."""

    def __init__(self, builder, graph, plan, source, vector_function, sides=None):
        super().__init__(builder)
        self.sides = sides
        self.plan, self.table_of, self.source = plan, plan.table, source
        source.item = self._item
        self._out: Any = None
        self._at: dict = {}  # addresses of the batches that are kept in memory
        self._tables: dict = {}  # tables of places, by the id of their array
        self._one = Emitter(builder, graph, REAL, source)
        self._wide = Emitter(builder, graph, VECTOR, source, vector_function)

    def _array(self, name):
        """The address of an array: outputs, parameters, state, or a batch kept in memory."""
        if name == "out":
            return self._out
        if name in ("y", "block"):
            return self.source.array(name)
        if isinstance(name, tuple):
            return self.source.table(name[1].start)
        if name not in self._at:  # an array of constants
            content = np.frombuffer(self.table_of.batches[name].data)
            self._at[name] = self.table(content, REAL)
        return self._at[name]

    def _load(self, name, place):
        value = self.builder.load(self.builder.gep(self._array(name), [place]))
        if value.type != REAL:
            value = self.builder.sitofp(value, REAL)
        return self.truth(self._is_truth(name), value)

    def _is_truth(self, name):
        return isinstance(name, int) and self.table_of.batches[name].truth

    # -- single nodes

    def _item(self, i):
        """The value of one node of a batch, outside loops."""
        batch = self.table_of.batch_of(i)
        if batch.number in self.plan.kept:
            return self._load(batch.number, WORD(i - batch.first))
        values: list = []
        for v in formula_of_one(self.plan, batch, i).values:
            values.append(self._value(v, values, self._one, None, ()))
        return values[-1]

    # -- in loops

    def _value(self, v, values, emitter, inner, ks):
        """Emit one value of a formula from the values before it.

        Parameters
        ----------
        v : boxes.Value
        values : list
            The values of the formula so far, which include the operands of `v`.
        emitter : Emitter
            The emitter of numbers, or of vectors.
        inner : int or None
            The axis along which vectors extend.
        ks : tuple of (axis, index)
            The indices of the surrounding loops.
        """
        if v.kind == "one":
            return self._one.nodes([v.data])[0]
        wide = emitter is self._wide
        if v.kind == "read":
            name, at, strides = v.data
            place = self._place(at, strides, ks)
            if wide and strides[inner] == 1 and self._is_real(name):
                begin = self._array(name)
                return self.truth(self._is_truth(name), self.vector(begin, place))
            if wide:
                return self._lanes(name, place, strides[inner])
            return self._load(name, place)
        if v.kind == "gather":
            return self._gathered(v.data, emitter, inner, ks)
        given = [values[a] for a in v.args]
        if wide:
            given = [x if isinstance(x.type, ir.VectorType) else self.splat(x) for x in given]
        op, data = v.data
        if op == "copy":
            return given[0]
        if op == "select" and self.sides is not None:
            self.sides.note(data, given[0])
        return emitter.emit(SimpleNamespace(op=op, data=data), given)

    def _is_real(self, name):
        return not isinstance(name, tuple) or self._array(name).type.pointee == REAL

    def _place(self, at, strides, ks):
        b, place = self.builder, WORD(at)
        for axis, k in ks:
            if strides[axis]:
                step = k if strides[axis] == 1 else b.mul(k, WORD(strides[axis]))
                place = b.add(place, step)
        return place

    def _lanes(self, name, place, stride):
        """A vector of elements that are not contiguous in memory."""
        b, found = self.builder, []
        for lane in range(WIDTH):
            at = b.add(place, WORD(lane * stride)) if lane else place
            found.append(self._load(name, at))
        return self._vector_of(found)

    def _vector_of(self, found):
        result = ir.Constant(ir.VectorType(found[0].type, WIDTH), ir.Undefined)
        for lane, value in enumerate(found):
            result = self.builder.insert_element(result, value, INDEX(lane))
        return result

    def _gathered(self, data, emitter, inner, ks):
        source, places, at, strides = data
        b = self.builder
        table = self._places_table(places)
        place, found = self._place(at, strides, ks), []
        for lane in range(WIDTH if emitter is self._wide else 1):
            entry = b.add(place, WORD(lane * strides[inner])) if lane else place
            index = b.sext(b.load(b.gep(table, [entry])), WORD)
            found.append(self._load(name_of(source), index))
        return self._vector_of(found) if emitter is self._wide else found[0]

    def _places_table(self, places):
        if id(places) not in self._tables:
            self._tables[id(places)] = self.table(places.astype(np.int32), INDEX)
        return self._tables[id(places)]
