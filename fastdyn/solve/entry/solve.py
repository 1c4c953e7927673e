"""The C functions of a solve: the state, the kernels, the result, and the entry from Python."""

from llvmlite import ir

from fastdyn.kernels.output.arguments import FRESH
from fastdyn.kernels.state.record import FINISHED, RUNNING
from fastdyn.run.memory import MEMORY
from fastdyn.run.memory import Y0 as LAUNCH_Y0

from .emit import SMALL, WORD, Emitter
from .objects import DATA, TUPLE
from .words import ENTRY, RUN


class Run(Emitter):
    """``run(table, record)``: the status after the first chunk of a solve from the stored state.

    The interpreter lock is held for a few steps, and released for further steps.
    """

    def __init__(self, module):
        super().__init__(module, "run", 2)
        record = self.args[1]
        launch, words, rest, n_steps = (
            self.load(record, RUN[name]) for name in ("launch", "words", "n_rest", "n_steps")
        )
        self.store(self.load(record, RUN["memory"]), launch, 8 * MEMORY)
        self.store(self.load(record, RUN["room"]), launch, 8 * LAUNCH_Y0)
        self.store(self.load(record, RUN["n_short"]), n_steps)
        advance = self.load(record, RUN["advance_kernel"])
        self.store(advance, self.load(record, RUN["advance"]))
        status = self.invoke(self.load(record, RUN["launch_kernel"]), launch)
        with self.b.if_then(self.all(self.equal(status, RUNNING), self.some(rest)), likely=False):
            self.store(WORD(0), words, 8 * FRESH)
            self.store(rest, n_steps)
            thread = self.python("PyEval_SaveThread")
            status_then = self.invoke(self.load(record, RUN["kernel"]), words)
            self.python("PyEval_RestoreThread", thread, returns=ir.VoidType())
            self.returns(status_then)
        self.returns(status)


class Plain(Emitter):
    """``plain(table, record)``: 1 after a solve that Python need not examine.

    Python compares the code with the function when a comparison is due, and when a decision took a
    side for the first time.  After every LOOK_EVERY solves, Python decides whether to change the
    kernel.
    """

    def __init__(self, module):
        super().__init__(module, "plain", 2)
        record = self.args[1]
        left_at, sides = self.load(record, RUN["left"]), self.load(record, RUN["sides"])
        left, look = self.load(left_at), self.load(record, RUN["look"])
        self.require(self.b.not_(self.b.or_(self.equal(left, 1), self.equal(look, 1))))
        with self.each(self.load(record, RUN["n_sides"])) as i:
            at = self.b.add(sides, self.b.shl(i, WORD(4)))
            taken, seen = self.load(self.load(at)), self.load(self.load(at, 8))
            self.require(self.none(self.b.and_(taken, self.b.not_(seen))))
        self.store(self.b.sub(left, WORD(1)), left_at)
        self.store(self.b.sub(look, WORD(1)), record, RUN["look"])
        self.returns()


class Entry(Emitter):
    """``entry(self, given, n_given, names)``: ``entry(y0, args, fun, t_span, t_eval)`` in Python.

    Missing arguments are the prepared arguments, if any; without `t_span` and `t_eval`, the span is
    the prepared span.  A call that is not plain goes to `slow` with all its arguments; without
    `slow` the call returns None.  If a solve turns out not to be plain after its start, the
    solve goes to `finish`.
    """

    def __init__(self, module, name, functions):
        super().__init__(module, name, 4)
        self.functions = functions
        self.own, self.given, self.n_given, self.names = self.args
        self.words = self.load(self.load(self.own, TUPLE), DATA)
        self.table = self.load(self.words, ENTRY["table"])
        self.refused = refused = self.b.append_basic_block("slow")
        self._solve()
        self.b.position_at_end(refused)
        slow = self._of_entry("slow")
        with self.b.if_then(self.none(slow)):
            self._new(self.known("none"))
            self.returns(self.known("none"))
        given = slow, self.given, self.n_given, self.names
        self.returns(self.python("PyObject_Vectorcall", *given))

    def require(self, condition):
        """Emit: continue by the slow way unless the condition holds."""
        after = self.b.append_basic_block()
        self.b.cbranch(condition, after, self.refused)
        self.b.position_at_end(after)

    def _of_entry(self, name):
        return self.load(self.words, ENTRY[name])

    def _new(self, thing):
        self.python("Py_IncRef", thing, returns=ir.VoidType())

    def _call(self, name, *args):
        return self.b.call(self.functions[name].function, [self.table, *args])

    def _needs(self, name, *args):
        """Emit: continue by the slow way unless a function returns 1."""
        self.require(self.some(self._call(name, *args)))

    def _argument(self, place, name):
        """An argument by its place; if the argument is missing or None, the prepared argument."""
        b, prepared = self.b, self._of_entry(name)
        with b.if_else(b.icmp_signed(">", self.n_given, WORD(place))) as (there, missing):
            with there:
                found = self.load(self.given, 8 * place)
                found = b.select(self.equal(found, self.known("none")), prepared, found)
                end = b.block
            with missing:
                end_without = b.block
        value = b.phi(WORD)
        value.add_incoming(found, end)
        value.add_incoming(prepared, end_without)
        self.require(self.some(value))
        return value

    def _calm(self):
        """Emit: continue by the slow way if NumPy's errors raise or call a handler."""
        now = self.room(1)
        failed = self.python("PyContextVar_Get", self.known("errors"), WORD(0), now, returns=SMALL)
        self.require(self.b.icmp_signed("==", failed, SMALL(0)))
        self.forget(self.load(now))
        self.require(self.equal(self.load(now), self.known("usual errors")))

    def _solve(self):
        self.require(self.none(self.names))
        most = self._of_entry("most_given")
        self.require(self.b.icmp_signed("<=", self.n_given, most))
        y0, args, fun = (self._argument(i, name) for i, name in enumerate(("y0", "args", "fun")))
        self.require(self.is_a(args, self.known("tuple")))
        n_args = self._of_entry("n_args")
        self.require(self.equal(self.python("PyTuple_Size", args), n_args))
        self._calm()
        idle = self._of_entry("idle")
        n_idle = self.python("PyList_Size", idle)
        self.require(self.b.icmp_signed(">", n_idle, WORD(0)))
        last = self.b.sub(n_idle, WORD(1))
        kept = self.python("PyList_GetItem", idle, last)
        self._new(kept)
        self.python("PyList_SetSlice", idle, last, n_idle, WORD(0), returns=SMALL)
        record = self.load(self.load(kept, TUPLE), DATA)
        slow, self.refused = self.refused, self.b.append_basic_block("given back")
        with self.b.goto_block(self.refused):
            self._give_back(idle, kept)
            self.b.branch(slow)
        self.require(self.some(self.load(record, RUN["live"])))
        left = self.load(self.known("left"))  # count of functions left to Python
        self.require(self.equal(left, self.load(record, RUN["left_then"])))
        self._read(record, y0, args, fun)
        with self.b.if_then(self.equal(self.n_given, 5)):
            self._needs("span", record, self.load(self.given, 24), self.load(self.given, 32))
        self._arrays(record, "Py_IncRef")
        status = self._call("run", record)
        with self.b.if_then(self.equal(status, FINISHED)):
            with self.b.if_then(self.some(self._call("plain", record))):
                result = self._call("result", record)
                self._arrays(record, "Py_DecRef")
                self._give_back(idle, kept)
                self.returns(result)
        self._finish(record, kept, status, fun, args)

    def _read(self, record, y0, args, fun):
        """Read the state and the outside values."""
        n, room, found, rows, n_rows = (
            self.load(record, RUN[name]) for name in ("n", "room", "found", "rows", "n_rows")
        )
        n_args = self._of_entry("n_args")
        self._needs("state", y0, n, room, WORD(1))
        self._needs("sized", record)
        self.store(fun, found)
        with self.each(n_args) as i:
            place = self.b.add(found, self.b.shl(i, WORD(3)))
            self.store(self.python("PyTuple_GetItem", args, i), place, 8)
        self._needs("follow", rows, n_rows, found, self.b.add(n_args, WORD(1)))

    def _arrays(self, record, function):
        """Take or release references to the arrays that the kernels read in place."""
        found, arrays = self.load(record, RUN["found"]), self.load(record, RUN["arrays"])
        with self.each(self.load(record, RUN["n_arrays"])) as i:
            at = self.load(self.b.add(arrays, self.b.shl(i, WORD(3))))
            self.python(function, self.load(self.b.add(found, at)), returns=ir.VoidType())

    def _give_back(self, idle, kept):
        self.python("PyList_Append", idle, kept, returns=SMALL)
        self.forget(kept)

    def _finish(self, record, kept, status, fun, args):
        """Emit the call of `finish`, by which Python continues the solve."""
        number, given = self.python("PyLong_FromLongLong", status), self.room(4)
        for i, thing in enumerate((kept, number, fun, args)):
            self.store(thing, given, 8 * i)
        finish = self._of_entry("finish")
        result = self.python("PyObject_Vectorcall", finish, given, WORD(4), WORD(0))
        self._arrays(record, "Py_DecRef")
        self.forget(number)
        self.forget(kept)
        self.returns(result)
