"""The variational equations of many numbers: the product of a Jacobian and S in loops over columns.

The state is y, followed by S row by row, with m numbers in each row.  The elements of df/dy and
df/dp that are not zero everywhere are computed once, with f.  Row i of S' is the sum of rows of S,
each times an element of row i of df/dy, and the elements of df/dp are added to it.  The length of
the code depends neither on the number of rows nor on m.
"""

import functools
import hashlib

import numpy as np
from llvmlite import ir

from fastdyn.trace.emit.memory import WIDTH, Memory
from fastdyn.trace.emit.numbers import INDEX, REAL, WORD
from fastdyn.trace.switching.switches import held_components

from ..functions import GROWING
from ..traced.code import Traced
from ..traced.pointer_form import text

MOST_TERMS = 8  # of a sum in one loop, each with its factor in a register


class Columns(Traced):
    """The variational equations as a Traced whose pointer form is loops.

    Parameters
    ----------
    factors : Traced
        It stores f, the elements of df/dy by rows, then the elements of df/dp.
    mode : Mode
    n, m : int
        The numbers of components and of directions.
    by_state, by_parameter : list of (int, int)
        For each element, its row, and its column in df/dy or in S.
    outputs : callable
        ``outputs()`` makes the nodes of y' and S', for forms without loops.
    """

    def __init__(self, factors, mode, n, m, by_state, by_parameter, outputs):
        self._factors = factors
        self._shape = (n, m)
        self._outputs = outputs
        self._by_state = by_state
        self._by_parameter = by_parameter
        super().__init__(factors.trace, mode, n * (1 + m))

    def _find_results(self):
        self.n_stored = self.n
        self.decisions = []

    @functools.cached_property
    def stored(self):
        with GROWING:
            return self._outputs()

    @functools.cached_property
    def held(self):
        if self._factors.in_batches:
            return ()
        n, _ = self._shape
        of_y = self._factors.stored[:n]  # of S, none: no factor depends on S
        return held_components(self._factors.trace.graph, of_y)

    def switches_by(self, slots, held=()):
        return self._factors.switches_by(slots, held)

    def key(self):
        place = repr((self._factors.key(), self._shape, self._by_state, self._by_parameter))
        return f"columns {hashlib.sha256(place.encode()).hexdigest()}"

    def text(self, symbol):
        return text(self._factors, symbol, lambda body: functools.partial(self._emit, body))

    def _emit(self, body, b, t, y, n, block, out):
        """Emit the pointer form around the code `body` of the factors."""
        memory = Memory(b)
        with memory.room(self._factors.n_stored) as factors:
            body(b, t, y, n, block, factors)
            self._products(memory, factors, y, out)
            self._add_by_parameters(memory, factors, out)

    def _products(self, memory, factors, y, out):
        """Emit f, and df/dy S: one loop for all rows that have as many terms."""
        b = memory.builder
        n, m = self._shape
        with memory.each(WORD(n), 1) as i:
            memory.put(b.load(b.gep(factors, [i])), out, i)
        for (n_terms, more), rows in self._sums().items():
            table = memory.table(np.array(rows, np.int32), INDEX)
            with memory.each(WORD(len(rows)), 1) as r:
                target, place, *terms = memory.row(table, r, 2 + n_terms)
                weights = [b.load(b.gep(factors, [b.add(place, WORD(q))])) for q in range(n_terms)]
                own = b.gep(out, [target])
                given = [b.gep(y, [at]) for at in terms]
                for width, j in _parts(memory, m):
                    total = _load(b, own, j, width) if more else None
                    for weight, row in zip(weights, given, strict=True):
                        term = b.fmul(_splat(b, weight, width), _load(b, row, j, width))
                        total = term if total is None else b.fadd(total, term)
                    total = _splat(b, REAL(0.0), width) if total is None else total
                    memory.put(total, own, j)

    def _sums(self):
        """The table of the sums by (number of terms, whether it goes on an earlier sum).

        A row of the table has the places of the result, of the first factor, and of the rows of S.
        """
        n, m = self._shape
        found = {}
        by_row = [[] for _ in range(n)]
        for e, (i, k) in enumerate(self._by_state):
            by_row[i].append((n + e, n + k * m))
        for i, terms in enumerate(by_row):
            for first in range(0, max(len(terms), 1), MOST_TERMS):
                part = terms[first : first + MOST_TERMS]
                place = part[0][0] if part else 0
                row = [n + i * m, place, *[at for _, at in part]]
                found.setdefault((len(part), first > 0), []).append(row)
        return dict(sorted(found.items(), key=lambda each: each[0][1]))

    def _add_by_parameters(self, memory, factors, out):
        """Emit the addition of df/dp: of WIDTH neighbours in a row at a time, then of the rest."""
        b = memory.builder
        n, m = self._shape
        first = self._shape[0] + len(self._by_state)
        found = {WIDTH: [], 1: []}
        e = 0
        while e < len(self._by_parameter):
            i, j = self._by_parameter[e]
            beside = [(i, j + k) for k in range(WIDTH)]
            width = WIDTH if self._by_parameter[e : e + WIDTH] == beside else 1
            found[width].append((n + i * m + j, first + e))
            e += width
        for width, places in found.items():
            if not places:
                continue
            table = memory.table(np.array(places, np.int32), INDEX)
            with memory.each(WORD(len(places)), 1) as r:
                target, place = memory.row(table, r, 2)
                more = _load(b, factors, place, width)
                memory.put(b.fadd(_load(b, out, target, width), more), out, target)


def _parts(memory, m):
    """Yield (width, first column) within the loops that take each of m columns once."""
    done = m - m % WIDTH
    if done:
        with memory.each(WORD(done), WIDTH) as j:
            yield WIDTH, j
    width = WIDTH // 2
    while width:
        if m - done >= width:
            yield width, WORD(done)
            done += width
        width //= 2


def _load(b, begin, k, width):
    kind = REAL if width == 1 else ir.VectorType(REAL, width)
    value = b.load(b.bitcast(b.gep(begin, [k]), kind.as_pointer()))
    value.align = 8
    return value


def _splat(b, value, width):
    if width == 1:
        return value
    none = ir.Constant(ir.VectorType(REAL, width), ir.Undefined)
    zeros = ir.Constant(ir.VectorType(INDEX, width), [0] * width)
    return b.shuffle_vector(b.insert_element(none, value, INDEX(0)), none, zeros)
