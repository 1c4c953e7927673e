"""C functions on words, as LLVM: reads and writes of memory, calls of Python, checks and loops.

All values are words of 64 bits; an address is a word, and so is a double's pattern of bits.
"""

import contextlib
from typing import Any

from llvmlite import ir

from .objects import PLACE, TYPE

WORD, SMALL, BIT, REAL = ir.IntType(64), ir.IntType(32), ir.IntType(1), ir.DoubleType()


class Emitter:
    """A function under construction, and the table of `objects` that it calls.

    ``require(condition)`` makes the function return 0 where the condition does not hold.
    """

    def __init__(self, module, name, n_args):
        self.function = ir.Function(module, ir.FunctionType(WORD, [WORD] * n_args), name)
        self.b = ir.IRBuilder(self.function.append_basic_block())
        self.args = self.function.args
        self.table = self.args[0]

    def load(self, address, offset=0, kind: Any = WORD) -> Any:
        """The word (or number of another kind) at an address."""
        place = self.b.add(address, WORD(offset)) if offset else address
        value = self.b.load(self.b.inttoptr(place, kind.as_pointer()))
        return self.b.zext(value, WORD) if kind == SMALL else value

    def store(self, value, address, offset=0):
        place = self.b.add(address, WORD(offset)) if offset else address
        self.b.store(value, self.b.inttoptr(place, value.type.as_pointer()))

    def known(self, name):
        """An object, or the address of a function, from the table."""
        return self.load(self.table, PLACE[name])

    def room(self, n_words):
        """The address of words on the stack."""
        with self.b.goto_entry_block():
            return self.b.ptrtoint(self.b.alloca(WORD, n_words), WORD)

    def invoke(self, address, *args, returns: Any = WORD):
        """Call a C function by its address."""
        kind = ir.FunctionType(returns, [a.type for a in args])
        return self.b.call(self.b.inttoptr(address, kind.as_pointer()), args)

    def python(self, name, *args, returns: Any = WORD):
        """Call a function of Python's C interface."""
        return self.invoke(self.known(name), *args, returns=returns)

    def forget(self, thing):
        """Release a reference to an object."""
        self.python("Py_DecRef", thing, returns=ir.VoidType())

    def copy(self, source, target, n_words):
        with self.each(n_words) as i:
            at = self.b.shl(i, WORD(3))
            self.store(self.load(self.b.add(source, at)), self.b.add(target, at))

    # -- conditions

    def equal(self, a, b):
        return self.b.icmp_signed("==", a, WORD(b) if isinstance(b, int) else b)

    def none(self, a):
        return self.equal(a, 0)

    def some(self, a):
        return self.b.icmp_signed("!=", a, WORD(0))

    def all(self, *conditions):
        found = conditions[0]
        for condition in conditions[1:]:
            found = self.b.and_(found, condition)
        return found

    def size(self, number):
        """The absolute value of a float."""
        return self.b.select(
            self.b.fcmp_ordered("<", number, REAL(0.0)), self.b.fneg(number), number
        )

    def is_a(self, thing, kind):
        """Whether the type of an object is exactly `kind`."""
        return self.equal(self.load(thing, TYPE), kind)

    def require(self, condition):
        """Return 0 unless the condition holds."""
        with self.b.if_then(self.b.not_(condition), likely=False):
            self.b.ret(WORD(0))

    def returns(self, value: Any = 1):
        self.b.ret(WORD(value) if isinstance(value, int) else value)

    # -- the flow

    @contextlib.contextmanager
    def each(self, count):
        """A loop over ``range(count)``, which may be empty."""
        b = self.b
        before = b.block
        head, body, after = (b.append_basic_block() for _ in range(3))
        b.branch(head)
        b.position_at_end(head)
        i = b.phi(WORD)
        i.add_incoming(WORD(0), before)
        b.cbranch(b.icmp_signed("<", i, count), body, after)
        b.position_at_end(body)
        yield i
        i.add_incoming(b.add(i, WORD(1)), b.block)
        b.branch(head)
        b.position_at_end(after)

    def choose(self, which, cases):
        """The value that ``cases[which]()`` emits; `which` is the key of a case."""
        b = self.b
        before, after = b.block, b.append_basic_block()
        found = []
        for number, emit in cases.items():
            block = b.append_basic_block()
            b.position_at_end(block)
            found.append((number, block, emit(), b.block))
            b.branch(after)
        b.position_at_end(before)
        switch = b.switch(which, found[-1][1])
        for number, block, _, _ in found[:-1]:
            switch.add_case(WORD(number), block)
        b.position_at_end(after)
        value = b.phi(found[0][2].type)
        for _, _, emitted, end in found:
            value.add_incoming(emitted, end)
        return value
