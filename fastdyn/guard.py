"""What a function must not do with vectors, found once its types are known.

The state arrives as a tuple of vectors.  An array would be added and compared component by
component; a tuple would be joined, or compared as a whole: such code runs one trajectory at a time.
"""

from numba.core import errors, ir, types
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.extending import overload

from .kernels.calls import BARE
from .kernels.vector import Mask, Vector

RAISES = (ir.Raise, ir.StaticRaise)


def _holds_vectors(ty):
    if isinstance(ty, types.BaseTuple):
        return any(map(_holds_vectors, ty))
    return isinstance(ty, Vector)


@register_pass(mutates_CFG=False, analysis_only=True)
class Guard(FunctionPass):
    """Refuse what would mean something else on vectors, or cannot be done in one lane alone."""

    _name = "fastdyn_guard"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        if not any(map(_holds_vectors, state.args)):
            return False
        for block in state.func_ir.blocks.values():
            for statement in block.body:
                if isinstance(statement, RAISES):
                    raise errors.TypingError("it raises an exception", loc=statement.loc)
                value = getattr(statement, "value", None)
                if isinstance(value, ir.Expr) and value.op in ("binop", "inplace_binop"):
                    for side in (value.lhs, value.rhs):
                        if isinstance(state.typemap[side.name], types.BaseTuple):
                            raise errors.TypingError(
                                "it computes with the whole state at once", loc=statement.loc
                            )
        return False


@overload(bool, jit_options=BARE)
def _truth(value):
    if isinstance(value, Mask | Vector):
        raise errors.TypingError("a branch depends on the state or on a varying parameter")
