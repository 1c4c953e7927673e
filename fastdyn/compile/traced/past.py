"""Emits reads of the past of a delay equation: a few components at once in the function, or a call.

The kernel is `state_before` of `kernels/output/dense_output.py`; where the delay is zero, the past
is the present state (and moves with it as one).  Most reads are of the polynomial
of the last read at the same place, or of the one beside: where few components are read, such reads
are in the function, with the same bits; all others call the kernel.  Mackey and Glass's equation
by Tsit5 takes 1.6 times the time of a loop in C++ in place of 2.1.
"""

from llvmlite import ir

from fastdyn.kernels.output import arguments as words
from fastdyn.kernels.vector.instructions import BIT, REAL
from fastdyn.trace.emit.memory import Memory
from fastdyn.trace.emit.numbers import BY_KERNELS
from fastdyn.trace.operations.delays import PAST

from .equations import WORD, called, entry, room, row_words

FEW_READ = 16  # a component alone costs as much as so many of a whole past state
FEW_PLACES = 4  # reads of a function up to which each has its own code
FEW_COMPONENTS = 3  # of more, the kernel computes four at once, in vectors
NEAR = "fastdyn_past_near"


def past(emitter, node, args):
    """The address of the n numbers of the state at an earlier time; None where few are read."""
    if FEW_READ * emitter.reads[node.key] <= node.data[0]:
        return None
    return _read(emitter, node, args, 0, node.data[0])


def of_past(emitter, node, args):
    """A component of a past state."""
    if args[0] is not None:
        return entry(emitter, node, args)
    (found,) = node.args
    given = [emitter.value(each) for each in found.args]
    return emitter.builder.load(_read(emitter, found, given, node.data, 1))


def _read(emitter, node, args, first, count):
    """The address of `count` components from `first` on of a past state."""
    b = emitter.builder
    _, n_words, order = node.data
    numbers = room(b, REAL, count)
    history = emitter.source.table(node.args[1].data)
    place = WORD(node.args[0].key % words.PAST_PLACES)

    def by_kernel():
        if order == 1:
            called_kernel()
            return
        with b.if_else(b.fcmp_ordered("==", args[0], args[2]), likely=False) as (now, before):
            with now, Memory(b).each(WORD(count), 1) as i:
                state = emitter.source.array("y")
                present = b.load(b.gep(state, [b.add(WORD(first), i)])) if order == 0 else REAL(1.0)
                b.store(present, b.gep(numbers, [i]))
            with before:
                called_kernel()

    def called_kernel():
        asked = [place, b.bitcast(args[0], WORD), b.bitcast(args[2], WORD), WORD(order)]
        out = row_words(b, numbers, count)
        called(b, PAST, [*row_words(b, history, n_words), *asked, WORD(first), *out])

    if order or count > FEW_COMPONENTS:
        by_kernel()
        return numbers
    near = _near(b.module, len(emitter.reads) <= FEW_PLACES)
    found = b.call(near, [history, place, args[0], WORD(first), WORD(count), numbers])
    with b.if_then(b.not_(found), likely=False):
        by_kernel()
    return numbers


def _near(module, inlined):
    """The function ``i1 near(history, place, t, first, count, out)``.

    True if t is in the step of the hint of a place, or in one beside, and not in the last step; the
    components are then in `out`.
    """
    if NEAR in module.globals:
        return module.globals[NEAR]
    function = _declared(module, inlined)
    history, place, t, first, count, out = function.args
    names = "begin", "look", "hint", "beside", "other", "moved", "found", "far"
    begin, look, hinted, beside, other, moved, found, far = [
        function.append_basic_block(name) for name in names
    ]
    ir.IRBuilder(far).ret(BIT(0))

    b = ir.IRBuilder(begin)
    of_history = b.bitcast(history, WORD.as_pointer())

    def word(b, i):
        return b.load(b.gep(of_history, [i if isinstance(i, ir.Value) else WORD(i)]))

    def numbers_of(b, i):
        return b.inttoptr(word(b, i), REAL.as_pointer())

    still = b.icmp_signed("==", word(b, words.PAST_BEGINS), WORD(0))
    t0 = b.load(b.gep(history, [WORD(words.PAST_T0)]))
    b.cbranch(b.and_(still, b.fcmp_ordered(">", t, t0)), look, far)

    b = ir.IRBuilder(look)
    n_steps = b.load(b.inttoptr(word(b, words.PAST_COUNT), WORD.as_pointer()))
    last = b.sub(n_steps, WORD(2))  # the last step may end before its polynomial
    place_of = b.add(place, WORD(words.PAST_HINT))
    hint = word(b, place_of)
    spans = numbers_of(b, words.PAST_SPANS)
    b.cbranch(b.icmp_signed("<=", hint, last), hinted, far)

    b = ir.IRBuilder(hinted)
    inside, start, after = _within(b, spans, hint, t)
    b.cbranch(inside, found, beside)

    b = ir.IRBuilder(beside)
    later = b.fcmp_ordered("<=", after, t)
    near = b.add(hint, b.select(later, WORD(1), WORD(-1)))
    b.cbranch(b.icmp_unsigned("<=", near, last), other, far)

    b = ir.IRBuilder(other)
    inside, start_of_other, _ = _within(b, spans, near, t)
    b.cbranch(inside, moved, far)

    b = ir.IRBuilder(moved)
    b.store(near, b.gep(of_history, [place_of]))
    b.branch(found)

    b = ir.IRBuilder(found)
    k = b.phi(WORD)
    t_old = b.phi(REAL)
    for step, begins, block in ((hint, start, hinted), (near, start_of_other, moved)):
        k.add_incoming(step, block)
        t_old.add_incoming(begins, block)
    size = b.load(b.gep(spans, [b.add(b.shl(k, WORD(1)), WORD(1))]))
    n = word(b, words.PAST_N)
    rows = word(b, words.PAST_ROWS)
    d = b.gep(numbers_of(b, words.PAST_D), [b.add(b.mul(k, b.mul(rows, n)), first)])
    x = b.fdiv(b.fsub(t, t_old), size)
    with Memory(b).each(count, 1) as i:
        b.store(_polynomial(b, b.gep(d, [i]), b.sub(rows, WORD(1)), n, x), b.gep(out, [i]))
    b.ret(BIT(1))
    return function


def _declared(module, inlined):
    numbers = REAL.as_pointer()
    kind = ir.FunctionType(BIT, [numbers, WORD, REAL, WORD, WORD, numbers])
    function = ir.Function(module, kind, NEAR)
    function.linkage = "internal"
    function.attributes.add("alwaysinline" if inlined else "noinline")
    return function


def _within(b, spans, k, t):
    """Whether t is in step k, and the borders of the step."""
    start, after = [b.load(b.gep(spans, [b.add(b.shl(k, WORD(1)), WORD(i))])) for i in (0, 2)]
    inside = b.and_(b.fcmp_ordered("<=", start, t), b.fcmp_ordered("<", t, after))
    return inside, start, after


def _polynomial(b, d, last, n, x):
    """The value at x of a component whose rows lie n numbers apart, with the kernel's bits.

    The factors of the rows behind the first are x and 1 - x in turn.
    """
    rest = b.fsub(REAL(1.0), x)
    by_x = b.icmp_signed("==", b.and_(last, WORD(1)), WORD(1))
    top = b.fadd(b.load(b.gep(d, [b.mul(last, n)])), REAL(0.0))
    starts = last, top, b.select(by_x, x, rest), b.select(by_x, rest, x)
    before = b.block
    body = b.append_basic_block()
    after = b.append_basic_block()
    b.branch(body)
    b.position_at_end(body)
    j = b.phi(WORD)
    total, factor, other = [b.phi(REAL) for _ in range(3)]
    below = b.sub(j, WORD(1))
    following = b.fadd(b.load(b.gep(d, [b.mul(below, n)])), b.fmul(total, factor))
    for place, start, value in zip(
        (j, total, factor, other), starts, (below, following, other, factor), strict=True
    ):
        place.add_incoming(start, before)
        place.add_incoming(value, body)
    b.cbranch(b.icmp_signed(">", below, WORD(0)), body, after)
    b.position_at_end(after)
    return following


def calls_kernel():
    """Register the code of these operations."""
    BY_KERNELS["past"] = past
    BY_KERNELS["of_past"] = of_past
    BY_KERNELS["of_slope"] = of_past
