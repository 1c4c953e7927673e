"""Numba's compiler without the work that kernels do not need.

Numba's own pipeline runs 27 passes, for closures, ``with``, array expressions and more, and counts
the references of each array at each call.  Kernels have no use for these passes, and own no memory.
Four fifths of the time of a first solve were Numba's in Python, nearly in proportion to the
instructions that Numba made, 90 000 for Radau.  `Lean` runs twelve passes; its lowering counts no
references, and indexes C-contiguous arrays by whole numbers without a copy of the array's record on
the stack: 48 000 instructions.  The bits of the results are equal.  LLVM, because this is the step
of Numba that writes LLVM.

Parts of Numba that are not public: the names of its passes, `BaseNativeLowering`, the methods of
`Lower` that `_LeanLower` overrides, `NRTContext`, `load_item` and `store_item`.  If a part is
missing, this module cannot be imported, and kernels take Numba's own pipeline.
"""

from llvmlite import ir
from numba import types
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.runtime.context import NRTContext
from numba.core.typed_passes import (
    BaseNativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FixupArgs,
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    RewriteSemanticConstants,
    TranslateByteCode,
)
from numba.np.arrayobj import load_item, store_item

from .arrays import borrowed, field_of

for _part in ("incref", "decref", "loadvar", "typeof", "lower_getitem", "lower_setitem"):
    getattr(Lower, _part)

_OF_KERNELS: dict = {}


class _Borrowed(NRTContext):
    """The reference counts of memory that belongs to the caller: none."""

    def incref(self, builder, typ, value):
        pass

    def decref(self, builder, typ, value):
        pass


class _LeanLower(Lower):
    """Numba's lowering, but for counts of references and the indexing of C-contiguous arrays."""

    def __init__(self, context, *given, **options):
        # Functions of Numba's that a kernel calls count no references either: users' functions must
        # not meet them.
        context = context.subtarget(cached_internal_func=_OF_KERNELS)
        context.nrt = _Borrowed(context, context.enable_nrt)
        super().__init__(context, *given, **options)

    def incref(self, typ, val):
        pass

    def decref(self, typ, val):
        pass

    def lower_getitem(self, resty, expr, value, index, signature):
        array = self.typeof(value.name)
        indices = _integers(signature.args[1])
        if not self._plain(array, indices):
            return super().lower_getitem(resty, expr, value, index, signature)
        found = self.loadvar(value.name)
        place = self._place(array, found, indices, index, signature.args[1])
        if len(indices) == array.ndim:
            item = load_item(self.context, self.builder, array, place)
            return self.context.cast(self.builder, item, array.dtype, resty)
        return self._part(array, found, resty, place, len(indices))

    def lower_setitem(self, target_var, index_var, value_var, signature):
        array = self.typeof(target_var.name)
        indices = _integers(signature.args[1])
        if not self._plain(array, indices) or len(indices) != array.ndim:
            return super().lower_setitem(target_var, index_var, value_var, signature)
        context = self.context
        builder = self.builder
        kind = self.typeof(value_var.name)
        value = context.cast(builder, self.loadvar(value_var.name), kind, signature.args[2])
        value = context.cast(builder, value, signature.args[2], array.dtype)
        found = self.loadvar(target_var.name)
        place = self._place(array, found, indices, index_var, signature.args[1])
        store_item(context, builder, array, value, place)

    def _plain(self, array, indices):
        """Whether an array is C-contiguous, and the indices are whole numbers without a check."""
        return (
            type(array) is types.Array
            and array.layout == "C"
            and 0 < len(indices) <= array.ndim
            and not self.context.enable_boundscheck
        )

    def _field(self, *given):
        return field_of(self.context, self.builder, *given)

    def _place(self, array, value, indices, index, kind):
        """The address of an element, or of the first element of a part; Numba's arithmetic."""
        context = self.context
        builder = self.builder
        at = None
        given = context.cast(builder, self.loadvar(index.name), self.typeof(index.name), kind)
        several = isinstance(kind, types.BaseTuple)
        for axis in range(array.ndim):
            size = self._field(array, value, "shape", axis) if at is not None else None
            at = at and builder.mul(at, size)
            if axis < len(indices):
                one = builder.extract_value(given, axis) if several else given
                one = self._counted(array, value, axis, indices[axis], one)
                at = builder.add(at, one) if at is not None else one
        return builder.gep(self._field(array, value, "data"), [at])

    def _counted(self, array, value, axis, kind, index):
        """An index from the start of its axis: negative indices count from the end."""
        context = self.context
        builder = self.builder
        index = context.cast(builder, index, kind, types.intp if kind.signed else types.uintp)
        if not kind.signed:
            return index
        if isinstance(index, ir.Constant) and isinstance(index.constant, int):
            if index.constant >= 0:
                return index
            return builder.add(index, self._field(array, value, "shape", axis))
        wrapped = builder.add(index, self._field(array, value, "shape", axis))
        return builder.select(builder.icmp_signed("<", index, index.type(0)), wrapped, index)

    def _part(self, array, value, resty, place, n):
        """The part of an array behind its first `n` axes, from `place` on."""
        shape, strides = [
            [self._field(array, value, name, axis) for axis in range(n, array.ndim)]
            for name in ("shape", "strides")
        ]
        return borrowed(self.context, self.builder, resty, place, shape, strides)


def _integers(kind):
    """The types of the indices, if all are whole numbers; else none."""
    kinds = tuple(kind) if isinstance(kind, types.BaseTuple) else (kind,)
    return kinds if all(isinstance(each, types.Integer) for each in kinds) else ()


@register_pass(mutates_CFG=True, analysis_only=False)
class _LeanLowering(BaseNativeLowering):
    _name = "lean_lowering"
    lowering_class = _LeanLower  # pyright: ignore[reportAssignmentType]


PASSES = (
    TranslateByteCode, FixupArgs, IRProcessing, RewriteSemanticConstants, DeadBranchPrune,
    GenericRewrites, ReconstructSSA, DeadBranchPrune, NopythonTypeInference, PreLowerStripPhis,
    _LeanLowering, NoPythonBackend,
)  # fmt: skip


class Lean(CompilerBase):
    """Numba's compiler with the passes that kernels need.

    No pass marks where a variable dies, as the death of a variable frees nothing.
    """

    def define_pipelines(self):
        manager = PassManager("kernels")
        for each in PASSES:
            manager.add_pass(each, each.__name__)
        manager.finalize()
        return [manager]
