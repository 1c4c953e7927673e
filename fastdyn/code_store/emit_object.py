"""From Numba's libraries to object code with one visible symbol, independent of this process.

Numba lowers a function and every function that it calls into a library each.  `deferred` prevents
the optimisation and translation of each library; `sealed` links the libraries, makes all but one
symbol internal, optimises and translates the whole once.
"""

# Numba and llvmlite declare fewer attributes than their objects have.
# pyright: reportAttributeAccessIssue=false

import inspect

import llvmlite.binding as llvm
import numba  # noqa: F401  # waits for an import in another thread; a submodule's does not
from llvmlite import ir
from numba.core import types
from numba.core.registry import cpu_target
from numba.np.numpy_support import as_dtype

from fastdyn.kernels.calls.block import FAILED
from fastdyn.kernels.calls.calling_convention import WORD, values_of

from . import runtime, unlinked
from .deferred import optimise_library
from .object_file import Unsealable
from .target import drop_unused, internal, settled


def of(dispatcher, signature, symbol):
    """The object code of a dispatcher for a signature, its needs, and the arguments of a kernel.

    A kernel returns a status, and takes its arguments in words; a function returns nothing.
    """
    dispatcher.compile(signature)
    result = dispatcher.get_compile_result(signature)
    kernel = signature.return_type != types.none
    code, needs = sealed(result, symbol, kernel)
    names = inspect.signature(dispatcher.py_func).parameters
    return code, needs, arguments(names, result.signature) if kernel else []


def sealed(result, symbol, kernel):
    """A compiled function as object code.

    Parameters
    ----------
    result : CompileResult
        The result of a compilation within `deferred`; call `sealed` within `deferred`, too.
    symbol : str
        The name of the function in the object code.
    kernel : bool
        True for code that takes its arguments in words (`kernels/calls/calling_convention.py`);
        functions of the user keep Numba's calling convention.

    Returns
    -------
    code : bytes
    needs : list of str
        Symbols that the code calls.

    Raises
    ------
    Unsealable
    """
    module = _linked(result, symbol, kernel)
    internal(module, symbol)
    drop_unused(module)  # entries for Python and C, before the optimiser looks at them
    _optimise(module)
    return settled(module, symbol)


def without_function(dispatcher, signature):
    """The kernel of a dispatcher that calls `unlinked.FUNCTION`, compiled within `deferred`."""
    dispatcher.compile(signature)
    result = dispatcher.get_compile_result(signature)
    names = inspect.signature(dispatcher.py_func).parameters
    bitcode = unlinked.without_function(_linked(result, unlinked.KERNEL, True))
    return unlinked.Unlinked(bitcode, arguments(names, result.signature))


def _linked(result, symbol, kernel):
    """A module with all of a compiled function's code."""
    _check_origin(result.library)
    result.library._ensure_finalized()
    module = llvm.parse_bitcode(result.library._final_module.as_bitcode())
    if kernel:
        entry = llvm.parse_assembly(_entry(result, symbol))
        entry.data_layout = module.data_layout
        module.link_in(entry)
    else:
        module.get_function(result.fndesc.llvm_func_name).name = symbol
    memory = llvm.parse_assembly(runtime.ASSEMBLY)
    memory.triple = module.triple
    memory.data_layout = module.data_layout
    module.link_in(memory)
    return module


def _check_origin(library):
    """Refuse code from Numba's own cache: its names are unique only in the process that made it."""
    seen = set()
    todo = [library]
    while todo:
        one = todo.pop()
        if one in seen:
            continue
        seen.add(one)
        if one._disable_inspection:
            raise Unsealable("it calls a function from Numba's own cache (cache=True)")
        todo += one._linking_libraries


def _entry(result, symbol):
    """Text of a module with ``int64 symbol(int64 *words)``, which calls the compiled function."""
    context = cpu_target.target_context
    module = context.codegen()._create_empty_module(symbol)
    entry = ir.Function(module, ir.FunctionType(WORD, [WORD.as_pointer()]), symbol)
    builder = ir.IRBuilder(entry.append_basic_block())
    tys = result.signature.args
    status, value = context.call_conv.call_function(
        builder,
        context.declare_function(module, result.fndesc),
        types.int64,
        tys,
        values_of(context, builder, tys, entry.args[0]),
    )
    builder.ret(builder.select(status.is_ok, value, WORD(FAILED)))
    return str(module)


def _optimise(module):
    """Run Numba's own two rounds of optimisation, under Numba's settings."""
    library = cpu_target.target_context.codegen().create_library(module.name)
    library._final_module = module
    optimise_library(library)


def arguments(names, signature):
    """The arguments of a kernel, for `Call`: (name, kind) each.

    The fields of a named tuple are "name.field".
    """
    return [
        list(pair)
        for name, ty in zip(names, signature.args, strict=True)
        for pair in _kinds(name, ty)
    ]


def _kinds(name, ty):
    if isinstance(ty, types.BaseNamedTuple):
        for field, part in zip(ty.fields, ty.types, strict=True):
            yield from _kinds(f"{name}.{field}", part)
    elif isinstance(ty, types.Array):
        yield name, f"{as_dtype(ty.dtype).str}:{ty.ndim}"
    else:
        yield name, ty.name
