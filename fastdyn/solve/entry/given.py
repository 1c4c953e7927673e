"""The C functions that read a state and a span of time, as the user gives them."""

import math

from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE

from .emit import REAL, SMALL, WORD, Emitter
from .follow import is_plain
from .objects import DATA, NDIM, SHAPE
from .words import RUN


class Number(Emitter):
    """``number(table, thing, place, whole)``: 1 if an object is a float; stores it at `place`.

    With `whole`, an int of 64 bits is taken as a float, too.
    """

    def __init__(self, module):
        super().__init__(module, "number", 4)
        _, thing, place, whole = self.args
        of_python, of_numpy = (self.known(name) for name in ("float", "float of numpy"))
        with self.b.if_then(self.b.or_(self.is_a(thing, of_python), self.is_a(thing, of_numpy))):
            self.store(self.python("PyFloat_AsDouble", thing, returns=REAL), place)
            self.returns()
        self.require(self.all(self.some(whole), self.is_a(thing, self.known("int"))))
        beyond = self.room(1)
        number = self.python("PyLong_AsLongLongAndOverflow", thing, beyond)
        self.require(self.none(self.load(beyond, kind=SMALL)))
        self.store(self.b.sitofp(number, REAL), place)
        self.returns()


class State(Emitter):
    """``state(table, thing, n, room, whole)``: 1 if an object is n floats; copies them to `room`.

    The object may be a contiguous array of float64, or a list or tuple of numbers for `Number`.
    """

    def __init__(self, module, number):
        super().__init__(module, "state", 5)
        table, thing, n, room, whole = self.args
        with self.b.if_then(self.is_a(thing, self.known("ndarray"))):
            self.require(is_plain(self, thing))
            self.require(self.equal(self.load(thing, NDIM, SMALL), 1))
            self.require(self.equal(self.load(self.load(thing, SHAPE)), n))
            self.copy(self.load(thing, DATA), room, n)
            self.returns()
        is_list, is_tuple = (self.is_a(thing, self.known(name)) for name in ("list", "tuple"))
        self.require(self.b.or_(is_list, is_tuple))
        size, item = (
            self.b.select(is_list, self.known(f"PyList_{name}"), self.known(f"PyTuple_{name}"))
            for name in ("Size", "GetItem")
        )
        self.require(self.equal(self.invoke(size, thing), n))
        with self.each(n) as i:
            place = self.b.add(room, self.b.shl(i, WORD(3)))
            given = table, self.invoke(item, thing, i), place, whole
            self.require(self.some(self.b.call(number.function, given)))
        self.returns()


class Sized(Emitter):
    """``sized(table, record)``: 1 if the kernel suits the size of the state's largest component.

    The order of a series depends on this size.
    """

    def __init__(self, module):
        super().__init__(module, "sized", 2)
        record = self.args[1]
        n, room = self.load(record, RUN["n_sized"]), self.load(record, RUN["room"])
        with self.b.if_then(self.none(n)):
            self.returns()
        least, most = (self.load(record, RUN[name], REAL) for name in ("smallest", "largest"))
        enough = self.room(1)
        self.store(WORD(0), enough)
        with self.each(n) as i:
            value = self.load(self.b.add(room, self.b.shl(i, WORD(3))), kind=REAL)
            size = self.size(value)
            self.require(self.b.fcmp_ordered("<=", size, most))
            large = self.b.zext(self.b.fcmp_ordered(">=", size, least), WORD)
            self.store(self.b.or_(self.load(enough), large), enough)
        self.returns(self.load(enough))


class Span(Emitter):
    """``span(table, record, t_span, t_eval)``: 1 if a span and its times are plain.

    The function stores the span in the image of the memory, and the times as times of output.
    """

    def __init__(self, module, number, state):
        super().__init__(module, "span", 4)
        table, record, t_span, t_eval = self.args
        self.require(self.is_a(t_span, self.known("tuple")))
        self.require(self.equal(self.python("PyTuple_Size", t_span), 2))
        ends = self.room(2)
        for i in range(2):
            given = table, self.python("PyTuple_GetItem", t_span, WORD(i))
            found = self.b.call(number.function, [*given, self.b.add(ends, WORD(8 * i)), WORD(1)])
            self.require(self.some(found))
        t0, tf = (self.load(ends, 8 * i, REAL) for i in range(2))
        length = self.size(self.b.fsub(tf, t0))
        self.require(self.b.fcmp_ordered("<", length, REAL(math.inf)))
        self.require(self.b.fcmp_ordered(">", length, REAL(0.0)))
        forward = self.b.fcmp_ordered(">", tf, t0)
        direction = self.b.select(forward, REAL(1.0), REAL(-1.0))
        self._fill(record, t0, tf, direction, length)
        n, times = self.load(record, RUN["n_eval"]), self.load(record, RUN["t_eval"])
        with self.b.if_then(self.none(n)):
            self.returns(self.b.zext(self.equal(t_eval, self.known("none")), WORD))
        given = table, t_eval, n, times, WORD(0)
        self.require(self.some(self.b.call(state.function, given)))
        self._inside(times, n, t0, tf, direction)
        self.returns()

    def _fill(self, record, t0, tf, direction, length):
        image = self.load(record, RUN["image"])
        h_max = self.b.fmul(length, self.load(record, RUN["h_max_share"], REAL))
        values = {
            "t": t0, "t_old": t0, "t_end": tf, "t_stop": tf, "t_start": t0,
            "direction": direction, "h_max": h_max,
        }  # fmt: skip
        for name, value in values.items():
            self.store(value, image, STATE.fields[name][1])
        self.store(t0, image, STATE.itemsize + OUTPUT.fields["t_last"][1])

    def _inside(self, times, n, t0, tf, direction):
        """Require that times lie in the span, in the direction of the span."""

        def at(i):
            return self.load(self.b.add(times, self.b.shl(i, WORD(3))), kind=REAL)

        def rises(sign, a, b):
            a, b = self.b.fmul(direction, a), self.b.fmul(direction, b)
            self.require(self.b.fcmp_ordered(sign, a, b))

        last = self.b.sub(n, WORD(1))
        rises("<=", t0, at(WORD(0)))
        rises("<=", at(last), tf)
        with self.each(last) as i:
            rises("<", at(i), at(self.b.add(i, WORD(1))))
