"""Reductions over the components of a state, such as sums, in one order for every storage.

LLVM, because Numba does not load four numbers of a row as a vector, from any number of
rows.
"""

from llvmlite import ir
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.options import INTERNAL, njit
from ..vector.instructions import splat
from ..vector.number import Vector
from .elementwise import ROW, data_of, element, length_of, load

PARTS = 4  # partial results, so that rows can be added four at a time


@njit(**INTERNAL)
def add(a, b):
    return a + b


def _reduce_rows(context, builder, call, call_wide, start, rows):
    """The four partial results of `reduce_components` over rows."""
    n = length_of(context, builder, *rows[0])
    pointers = [data_of(context, builder, *row) for row in rows]
    kind = ir.VectorType(start.type, PARTS)
    index = n.type
    wide = cgutils.alloca_once_value(builder, splat(builder, start, PARTS))
    whole = builder.and_(n, index(-PARTS))
    with cgutils.for_range_slice(builder, index(0), whole, index(PARTS), inc=True) as (i, _):
        places = [builder.bitcast(builder.gep(p, [i]), kind.as_pointer()) for p in pointers]
        components = [load(builder, place) for place in places]
        builder.store(call_wide(builder, [builder.load(wide), *components]), wide)
    lane_type = ir.IntType(32)
    sums = []
    for lane in range(PARTS):
        part = builder.extract_element(builder.load(wide), lane_type(lane))
        place = cgutils.alloca_once_value(builder, part)
        at = builder.add(whole, index(lane))
        if lane < PARTS - 1:
            with builder.if_then(builder.icmp_signed("<", at, n)):
                components = [builder.load(builder.gep(p, [at])) for p in pointers]
                builder.store(call(builder, [part, *components]), place)
        sums.append(builder.load(place))
    return sums


@intrinsic
def reduce_components(typingctx, function, merge, start, values):
    """Accumulate ``total = function(total, *components)`` over the components of `values`.

    Every storage computes four partial results; component i belongs to result i % 4.  ``merge``
    joins the partial results.  Both functions are compiled, and take and return numbers; `values`
    is a tuple of state values.
    """
    number = element(values[0])
    join = merge.get_call_type(typingctx, (number, number), {})
    inner = function.get_call_type(typingctx, (number,) * (len(values) + 1), {})
    rows = values[0] == ROW
    if rows:  # four components at once, with the roundings of the scalar loop
        four = Vector(PARTS, exact=True)
        wide = function.get_call_type(typingctx, (four,) * (len(values) + 1), {})

    def codegen(context, builder, signature, args):
        call = context.get_function(function, inner)
        both = context.get_function(merge, join)
        parts = [(t, builder.extract_value(args[3], i)) for i, t in enumerate(values)]
        if rows:
            call_wide = context.get_function(function, wide)
            sums = _reduce_rows(context, builder, call, call_wide, args[2], parts)
        else:
            sums = [args[2]] * PARTS
            for i in range(len(values[0])):
                components = [builder.extract_value(v, i) for _, v in parts]
                sums[i % PARTS] = call(builder, [sums[i % PARTS], *components])
        a, b, c, d = sums
        return both(builder, (both(builder, (a, b)), both(builder, (c, d))))

    return number(function, merge, number, values), codegen
