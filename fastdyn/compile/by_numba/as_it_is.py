"""A user's function as Numba compiles it, with its outside values as constants.

The functions that it calls are compiled, too.  A function of the user's own `@njit` keeps Numba's
rules.  Any other function is refused where Numba would compute otherwise than Python, and no
comparison at some states could be trusted to show the difference.
"""

# Numba's annotations are incomplete.
# pyright: reportIncompatibleMethodOverride=false, reportAttributeAccessIssue=false

import builtins
import operator
import types as python

import numpy as np
from numba import types
from numba.core import ir
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.typed_passes import NopythonTypeInference

from fastdyn.kernels.jit.options import OWNING, OWNING_INLINED, njit

from ..callables import EMPTY, Uncompilable, is_jitted
from ..fingerprint import of_library, outside
from ..sentences import located

CHECKED = {"boundscheck": True}  # an index out of bounds is an exception, as in Python
WHOLE = "it computes a whole number that may exceed 64 bits"
DIVIDES = "it divides by a whole number that may be zero"
TRUTHS = "it computes with truth values"
UNASSIGNED = "it may read `{}` before it assigns it"
IDENTITY = "it compares identities with `is`, and compiled code has values only"
SUMS = (operator.add, operator.iadd, operator.sub, operator.isub)
DIVISIONS = (
    operator.truediv, operator.itruediv, operator.floordiv, operator.ifloordiv, operator.mod,
    operator.imod,
)  # fmt: skip
SAFE = (  # of whole numbers and truth values, whatever their size
    operator.eq, operator.ne, operator.lt, operator.le, operator.gt, operator.ge, operator.not_,
    operator.and_, operator.or_, operator.xor, operator.pos,
)  # fmt: skip


def dispatcher(parts):
    """A dispatcher of a user's function, to be called with all its arguments."""
    function = parts.function
    jitted = parts.jitted
    code = function.__code__
    last = code.co_argcount + code.co_kwonlyargcount
    given = function.__code__.replace(co_argcount=last, co_kwonlyargcount=0)
    options = {**OWNING_INLINED, **parts.options, **CHECKED}
    if jitted:
        options["error_model"] = "python"
    return njit(**options, **({} if jitted else AS_PYTHON))(_with_constants(function, given, None))


def compiled(value):
    """An outside value as a constant of code: functions compiled, arrays copied."""
    if isinstance(value, np.ndarray):
        value = np.array(value, order="C")  # Numba would keep the address of strided memory
        value.flags.writeable = False
        return value
    if type(value) is tuple:
        return tuple(map(compiled, value))
    if is_jitted(value) and not of_library(value.py_func):
        return _recompiled(value)
    if not isinstance(value, python.FunctionType) or of_library(value):
        return value
    if value.__kwdefaults__ or value.__code__.co_kwonlyargcount:
        raise Uncompilable("it calls a function with keyword-only arguments")
    clone = _with_constants(value, value.__code__, value.__defaults__)
    return njit(**OWNING, **CHECKED, **AS_PYTHON)(clone)


def _recompiled(value):
    """An `@njit` function compiled again: its code may have old values of its globals."""
    options = {"error_model": "python", **value.targetoptions, **CHECKED}
    options.pop("nopython", None)
    function = value.py_func
    clone = _with_constants(function, function.__code__, function.__defaults__)
    made = njit(**{**OWNING, **options})(clone)
    if not value._can_compile:  # it takes and gives the types that the user has named
        for signature in value.nopython_signatures:
            made.compile(signature)
        made.disable_compile()
    return made


def _with_constants(function, code, defaults):
    """A copy of a function whose globals and closure variables never change."""
    held = {name: compiled(value) for name, value in outside(function)}
    cells = tuple([python.CellType(held[n]) if n in held else EMPTY for n in code.co_freevars])
    space = {"__builtins__": builtins, "__name__": function.__module__, **held}
    defaults = defaults and tuple(map(compiled, defaults))
    clone = python.FunctionType(code, space, function.__name__, defaults, cells)
    clone.__qualname__ = function.__qualname__
    return clone


# -- what Numba computes otherwise than Python


@register_pass(mutates_CFG=False, analysis_only=True)
class Refuse(FunctionPass):
    """Refuse what Numba computes otherwise, once types are known."""

    _name = "fastdyn_refuse"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        for block in state.func_ir.blocks.values():
            for statement in block.find_insts(ir.Assign):
                reason = _otherwise(statement, state.typemap, state.calltypes)
                if reason:
                    loc = statement.loc
                    raise Uncompilable(located(reason, (loc.filename, loc.line)))
        return False


class Compiler(CompilerBase):
    """Numba's pipeline with the pass Refuse."""

    def define_pipelines(self):
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(Refuse, NopythonTypeInference)
        manager.finalize()
        return [manager]


AS_PYTHON = {"pipeline_class": Compiler}


def _otherwise(statement, kinds, calls):
    """Why Python may compute an assigned value otherwise than Numba; None if it does not."""
    value = statement.value
    op = value.op if isinstance(value, ir.Expr) else None
    if op == "phi" and ir.UNDEFINED in value.incoming_values:
        return UNASSIGNED.format(statement.target.unversioned_name)
    if op == "call":
        given = [kinds[v.name] for v in value.args]
        function = kinds[value.func.name]
        made = calls[value].return_type
        named = getattr(function, "typing_key", None)
        if isinstance(function, types.Dispatcher) or not isinstance(made, types.Integer):
            return None
        whole = all(isinstance(kind, types.Integer) for kind in given)
        computes = named in (pow, divmod) or getattr(named, "__module__", "") == "_operator"
        is_float = any(isinstance(kind, types.Float) for kind in given)
        return WHOLE if is_float or (whole and computes) else None
    if op not in ("binop", "inplace_binop", "unary"):
        return None
    operands = [value.value] if op == "unary" else [value.lhs, value.rhs]
    given = [kinds[v.name] for v in operands]
    if value.fn in (operator.is_, operator.is_not):
        return None if any(isinstance(kind, types.NoneType) for kind in given) else IDENTITY
    if not all(isinstance(kind, types.Integer | types.Boolean) for kind in given):
        return None
    literal = [getattr(kind, "literal_value", None) for kind in given]
    if value.fn in SAFE:
        return None
    if any(isinstance(kind, types.Boolean) for kind in given):
        return TRUTHS
    if value.fn in DIVISIONS:
        return None if literal[1] else DIVIDES
    # a counter does not come to 2**63 within the life of a user
    counts = value.fn in SUMS and any(type(each) is int for each in literal)
    return None if counts or value.fn is operator.neg else WHOLE
