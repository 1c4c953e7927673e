"""The C function that makes a result."""

from fastdyn.kernels.state.record import STATE

from .emit import SMALL, WORD, Emitter
from .objects import COUNTS, DATA
from .words import RUN

DOUBLE, FORTRAN = 12, 2  # NumPy's number of float64; a flag of PyArray_New
COUNTED = "n_accepted n_rejected n_extra n_jacobians n_factorised".split()


class Result(Emitter):
    """``result(table, record)``: a new OdeResult with all fields, or 0 and an exception."""

    def __init__(self, module):
        super().__init__(module, "result", 2)
        record = self.args[1]
        memory, n = self.load(record, RUN["memory"]), self.load(record, RUN["n"])

        def place(name):
            return self.b.add(memory, self.load(record, RUN[name]))

        n_points, shape = self.load(place("n_points")), self.room(2)
        self.store(n, shape)
        self.store(n_points, shape, 8)
        self.found = self.python("PyObject_CallNoArgs", self.known("result"))
        self.require(self.some(self.found))
        self._need(self.python("PyDict_Update", self.found, self.known("template"), returns=SMALL))
        t = self._array(1, self.b.add(shape, WORD(8)), 0)
        self.copy(place("t"), self.load(t, DATA), n_points)
        self._field("t", t)
        y = self._array(2, shape, FORTRAN)
        self.copy(place("y"), self.load(y, DATA), self.b.mul(n, n_points))
        self._field("y", y)
        accepted, rejected, extra, jacobians, factorised = (
            self.load(place("state"), STATE.fields[name][1]) for name in COUNTED
        )
        trials = self.b.mul(self.load(record, RUN["n_stages"]), self.b.add(accepted, rejected))
        numbers = self.b.add(extra, trials), jacobians, factorised, accepted, rejected
        for name, number in zip(COUNTS, numbers, strict=True):
            self._field(name, self.python("PyLong_FromLongLong", number))
        self.returns(self.found)

    def _need(self, failed):
        """Emit: return without a result if a call has failed."""
        with self.b.if_then(self.b.icmp_signed("!=", failed, SMALL(0)), likely=False):
            self.forget(self.found)
            self.returns(0)

    def _array(self, n_axes, shape, flags):
        zero, word = SMALL(0), WORD(0)
        given = self.known("ndarray"), SMALL(n_axes), shape, SMALL(DOUBLE)
        made = self.python("PyArray_New", *given, word, word, zero, SMALL(flags), word)
        self._need(self.b.zext(self.none(made), SMALL))
        return made

    def _field(self, name, value):
        """Put a new object into the result."""
        self._need(self.b.zext(self.none(value), SMALL))
        failed = self.python("PyDict_SetItem", self.found, self.known(name), value, returns=SMALL)
        self.forget(value)
        self._need(failed)
