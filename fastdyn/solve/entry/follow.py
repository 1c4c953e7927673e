"""The C function that follows a compiled function: reads its outside values again.

A row is one read, as in `trace.reads.reads`: the first object, the step to the value, the check of
the value.  Numbers go into the block of the function.  A value of another kind or type ends the
following: the code does not hold.
"""

from typing import Any

from . import words as c
from .emit import BIT, REAL, SMALL, WORD, Emitter
from .objects import ATTRIBUTES, DATA, DESCR, FLAGS, NDIM, PLAIN, SHAPE


class Follow(Emitter):
    """``follow(table, rows, n_rows, found, n_roots)``: 1 if all rows hold, 0 if not.

    `found` has the function and its arguments, and gets the objects of the rows behind them.
    """

    def __init__(self, module, largest):
        super().__init__(module, "follow", 5)
        _, rows, n_rows, self.found, n_roots = self.args
        self._largest = largest
        with self.each(n_rows) as i:
            self.row = self.b.add(rows, self.b.mul(i, WORD(c.SIZE)))
            self.parent = self._object(self._field("parent"))
            value = self.choose(self._field("step"), self._steps())
            self.store(value, self._place(self.b.add(n_roots, i)))
            self.require(self.choose(self._field("check"), self._checks(value)))
            first = self._field("same")
            alone = self.none(first)
            self.require(self.b.or_(alone, self.equal(self._object(first), value)))
        self.returns()

    def _field(self, name, kind: Any = WORD):
        return self.load(self.row, c.ROW[name], kind)

    def _place(self, i):
        return self.b.add(self.found, self.b.shl(i, WORD(3)))

    def _object(self, i):
        return self.load(self._place(i))

    # -- steps

    def _steps(self):
        key = self._field("key")
        return {
            c.ITSELF: lambda: self.parent,
            c.GLOBAL: lambda: self.python(
                "PyDict_GetItem", self.python("PyFunction_GetGlobals", self.parent), key
            ),
            c.BUILTIN: lambda: self.python("PyDict_GetItem", self._field("scope"), key),
            c.CELL: lambda: self._in_cell(key),
            c.DEFAULT: lambda: self.python(
                "PyTuple_GetItem", self.python("PyFunction_GetDefaults", self.parent), key
            ),
            c.IN_TUPLE: lambda: self.python("PyTuple_GetItem", self.parent, key),
            c.IN_LIST: lambda: self.python("PyList_GetItem", self.parent, key),
            c.IN_DICT: lambda: self.python("PyDict_GetItem", self.parent, key),
            c.OWN: lambda: self.load(self.parent, ATTRIBUTES),
        }

    def _in_cell(self, key):
        """The content of a cell, a borrowed reference."""
        cells = self.python("PyFunction_GetClosure", self.parent)
        value = self.python("PyCell_Get", self.python("PyTuple_GetItem", cells, key))
        self.forget(value)
        return value

    # -- checks

    def _checks(self, value):
        def there(emit):
            """A check that first requires that the object exists."""

            def check():
                self.require(self.some(value))
                return emit(value)

            return check

        return {
            c.ANY: there(lambda _: BIT(1)),
            c.SAME: there(lambda value: self.equal(value, self._field("expected"))),
            c.ABSENT: lambda: self.none(value),
            c.EMPTY: lambda: self._is_empty(value),
            c.CODE: there(self._is_code),
            c.FLOAT: there(self._is_float),
            c.WHOLE: there(self._is_whole),
            c.TUPLE: there(lambda value: self._has_length(value, "tuple", "PyTuple_Size")),
            c.LIST: there(lambda value: self._has_length(value, "list", "PyList_Size")),
            c.KEYS: there(self._has_keys),
            c.ARRAY: there(self._is_array),
        }

    def _is_empty(self, attributes):
        """Whether a function has no attributes: no dict, or an empty dict."""
        with self.b.if_then(self.some(attributes)):
            self.require(self.none(self.python("PyDict_Size", attributes)))
        return BIT(1)

    def _is_code(self, value):
        self.require(self.is_a(value, self.known("function")))
        given = self.python("PyFunction_GetDefaults", value)
        self.require(self.none(self.python("PyFunction_GetKwDefaults", value)))
        with self.b.if_else(self.none(given)) as (without, with_defaults):
            with without:
                self.require(self.none(self._field("count")))
            with with_defaults:
                self.require(self.equal(self.python("PyTuple_Size", given), self._field("count")))
        return self.all(
            self.equal(self.python("PyFunction_GetCode", value), self._field("expected")),
            self.equal(self.python("PyFunction_GetGlobals", value), self._field("scope")),
        )

    def _is_float(self, value):
        self.require(self.is_a(value, self._field("expected")))
        return self._put(number := self.python("PyFloat_AsDouble", value, returns=REAL), number)

    def _is_whole(self, value):
        self.require(self.is_a(value, self._field("expected")))
        beyond = self.room(1)
        number = self.python("PyLong_AsLongLongAndOverflow", value, beyond)
        self.require(self.none(self.load(beyond, kind=SMALL)))
        self.require(self.b.icmp_signed("<=", number, WORD(self._largest)))
        self.require(self.b.icmp_signed(">=", number, WORD(-self._largest)))
        return self._put(number, self.b.sitofp(number, REAL))

    def _put(self, number, as_float):
        """Write a number into the block; return whether the code holds for the number."""
        place = self._field("place")
        with self.b.if_then(self.some(place)):
            self.store(number, place)
        same = self.equal(self.b.bitcast(as_float, WORD), self._field("value"))  # 0.0 is not -0.0
        return self.b.or_(self.none(self._field("fixed")), same)

    def _has_length(self, value, kind, size):
        self.require(self.is_a(value, self.known(kind)))
        return self.equal(self.python(size, value), self._field("count"))

    def _has_keys(self, value):
        """Whether a dict has the expected keys, compared by identity, in the expected order."""
        self.require(self.is_a(value, self.known("dict")))
        count, expected, room = self._field("count"), self._field("scope"), self.room(2)
        self.require(self.equal(self.python("PyDict_Size", value), count))
        self.store(WORD(0), room)
        with self.each(count) as i:
            given = value, room, self.b.add(room, WORD(8)), WORD(0)
            self.python("PyDict_Next", *given, returns=SMALL)
            key = self.load(self.b.add(expected, self.b.shl(i, WORD(3))))
            self.require(self.equal(self.load(room, 8), key))
        return BIT(1)

    def _is_array(self, value):
        """An array of the block's shape, whose numbers the function reads in place.

        The code may hold only for the present values of some of the numbers.
        """
        place, n_axes = self._field("place"), self._field("count")
        self.require(is_plain(self, value))
        self.require(self.equal(self.load(value, NDIM, SMALL), n_axes))
        shape = self.load(value, SHAPE)
        with self.each(n_axes) as i:
            at = self.b.shl(i, WORD(3))
            wanted = self.load(self.b.add(place, at), 8)
            self.require(self.equal(self.load(self.b.add(shape, at)), wanted))
        data, fixed = self.load(value, DATA), self._field("value")
        with self.each(self._field("fixed")) as i:
            at = self.b.add(fixed, self.b.shl(i, WORD(4)))
            number = self.load(self.b.add(data, self.load(at)))
            self.require(self.equal(number, self.load(at, 8)))
        self.store(data, place)
        return BIT(1)


def is_plain(e, value):
    """Whether an object is a contiguous, aligned array of float64."""
    e.require(e.is_a(value, e.known("ndarray")))
    flags = e.b.and_(e.load(value, FLAGS, SMALL), WORD(PLAIN))
    return e.all(e.equal(e.load(value, DESCR), e.known("float64")), e.equal(flags, PLAIN))
