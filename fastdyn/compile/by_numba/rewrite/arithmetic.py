"""Arithmetic whose results differ between Numba and Python.

An integer has any size in Python, and 64 bits in compiled code.  If a result does not fit, the
compiled function raises, and the solve continues in Python.  Arithmetic on truth values is refused;
so is arithmetic on lists, which are arrays for Numba.
"""

# Numba's annotations are incomplete.
# pyright: reportArgumentType=false, reportIncompatibleMethodOverride=false, reportOptionalCall=false

import operator

from llvmlite import ir as code
from numba import types
from numba.core import errors, ir
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.extending import intrinsic

from fastdyn.kernels.jit_options import OWNING, njit

from ..arguments import is_list

TOO_LARGE = "a whole number beyond 64 bits"
LIMIT = 2.0**63
# NumPy's True + True is True, Python's is 2.
OF_TRUTHS = (operator.add, operator.iadd, operator.mul, operator.imul)


def _with_flag(name):
    """LLVM's operation `name` on two int64; raises OverflowError if the result does not fit."""

    @intrinsic
    def operation(typingctx, a, b):
        def codegen(context, builder, signature, args):
            word = args[0].type
            kind = code.FunctionType(code.LiteralStructType([word, code.IntType(1)]), [word, word])
            both = builder.call(
                builder.module.declare_intrinsic(f"llvm.{name}.with.overflow", [word], kind), args
            )
            with builder.if_then(builder.extract_value(both, 1), likely=False):
                context.call_conv.return_user_exc(builder, OverflowError, (TOO_LARGE,))
            return builder.extract_value(both, 0)

        return types.int64(types.int64, types.int64), codegen

    return operation


_add, _subtract, _multiply = map(_with_flag, ("sadd", "ssub", "smul"))


@njit(**OWNING)
def _negative(a):
    return _subtract(0, a)


@njit(**OWNING)
def _shift_left(a, b):
    if not 0 <= b < 63:
        raise OverflowError(TOO_LARGE)
    return _multiply(a, 1 << b)


@njit(**OWNING)
def _power(a, b):
    """a ** b by products; OverflowError for b < 0, where Python's result is a float."""
    if b < 0:
        raise OverflowError(TOO_LARGE)
    result = 1
    for _ in range(b):
        result = _multiply(result, a)
    return result


@njit(**OWNING)
def _fitting(x):
    """x, or OverflowError if int(x), floor(x) or ceil(x) would not fit into 64 bits."""
    if not abs(x) < LIMIT:
        raise OverflowError(TOO_LARGE)
    return x


CHECKED = {
    operator.add: _add, operator.iadd: _add, operator.sub: _subtract, operator.isub: _subtract,
    operator.mul: _multiply, operator.imul: _multiply, operator.neg: _negative,
    operator.lshift: _shift_left, operator.ilshift: _shift_left,
    operator.pow: _power, operator.ipow: _power, pow: _power,
}  # fmt: skip


@register_pass(mutates_CFG=False, analysis_only=False)
class Arithmetic(FunctionPass):
    """Check or refuse operations, once types are known."""

    _name = "fastdyn_arithmetic"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        for block in state.func_ir.blocks.values():
            body = []
            for statement in block.body:
                value = getattr(statement, "value", None)
                if isinstance(value, ir.Expr) and value.op in ("binop", "inplace_binop", "unary"):
                    _refuse(value, state.typemap)
                    statement.value = _checked(value, state)
                elif isinstance(value, ir.Expr) and value.op == "call":
                    body += _fitted(value, statement.target.scope, state)
                    statement.value = _checked(value, state)
                body.append(statement)
            block.body = body
        return True


def _refuse(value, types_of):
    """Raise TypingError for 2 * [1, 2], which is [1, 2, 1, 2], and for True + True."""
    operands = [types_of[v.name] for v in value.list_vars()]
    arrays = [ty for ty in operands if isinstance(ty, types.Array)]
    if arrays and all(map(is_list, arrays)):
        raise errors.TypingError("it computes with a list", loc=value.loc)
    truths = all(isinstance(getattr(ty, "dtype", ty), types.Boolean) for ty in operands)
    if truths and value.fn in OF_TRUTHS:
        raise errors.TypingError("it computes with truth values", loc=value.loc)


def _checked(value, state):
    """The checked form of an expression on integers; any other expression unchanged."""
    if value.op == "call":  # such as pow(a, b), or operator.mul(a, b)
        called = getattr(state.typemap[value.func.name], "typing_key", None)
        operands = [] if value.kws or value.vararg else list(value.args)
    else:
        called = value.fn
        operands = [value.value] if value.op == "unary" else [value.lhs, value.rhs]
    names = ["value"] if len(operands) == 1 else ["lhs", "rhs"]
    function = CHECKED.get(called) if operands else None
    kinds = [state.typemap[v.name] for v in operands]
    whole = all(isinstance(ty, types.Integer | types.Boolean) for ty in kinds)
    if function is None or not whole or state.calltypes[value].return_type != types.int64:
        return value
    given = dict(zip(names, operands, strict=True))
    given |= {f"static_{name}": ir.UNDEFINED for name in names}
    op = "unary" if len(operands) == 1 else "binop"
    return _typed(ir.Expr(op=op, loc=value.loc, fn=function, **given), function, operands, state)


def _typed(expression, function, operands, state, kind=types.int64):
    """Store the signature of an expression that applies `function` to operands of type `kind`."""
    context = state.typingctx
    found = context.resolve_value_type(function).get_call_type(context, (kind,) * len(operands), {})
    state.calltypes[expression] = found
    return expression


def _fitted(call, scope, state):
    """The statements that check a float before its conversion to an integer."""
    signature, function = state.calltypes[call], state.typemap[call.func.name]
    floats = [isinstance(ty, types.Float) for ty in signature.args if signature is not None]
    if isinstance(function, types.Dispatcher) or floats != [True]:
        return []
    if signature.return_type != types.int64:
        return []
    given, loc = call.args[0], call.loc
    checked = ir.Expr(op="unary", loc=loc, fn=_fitting, value=given, static_value=ir.UNDEFINED)
    place = scope.redefine("$fastdyn_fitting", loc)
    state.typemap[place.name] = types.float64
    call.args = [place]
    return [ir.Assign(_typed(checked, _fitting, [given], state, types.float64), place, loc)]
