"""The target of code generation, and translation of LLVM text to object code, without Numba."""

# llvmlite declares fewer attributes than its objects have.
# pyright: reportAttributeAccessIssue=false

import functools
from typing import Any

import llvmlite.binding as llvm
from llvmlite.binding.ffi import ObjectRef
from llvmlite.binding.newpassmanagers import NewPassManager

from .loader import UnknownSymbol, initialise, provider
from .numba_settings import chosen, setting, settings
from .object_file import Unsealable, checked, symbols

# Lines of a function, beyond which LLVM does not optimise.  np.linalg.solve of 8 full rows has
# 1550: 0.11 s instead of 0.014, in 0.7 of the time; of 9 rows 2050: 0.15 s, in 0.26 of the time.
STRAIGHT = 2000
# Globals that the lowering process fills in later: an environment of Python objects, an address, a
# function that was not defined yet.
ENVIRONMENT = "NumbaEnv"
PROCESS_BOUND = ("_ZN08NumbaEnv", "numba.dynamic.globals", ".numba.unresolved$")
BACK_TO_PYTHON = "it goes back to Python (prints, or uses Python objects)"
# Processors on which Numba's `config.ENABLE_AVX` is off, or may be off.
WITHOUT_AVX = {"corei7-avx", "core-avx-i", "sandybridge", "ivybridge", "nocona"}


def processor(now=None):
    """The target: the triple, the processor and its features, from Numba's `settings`."""
    now = now or settings()
    return _processor(now["CPU_NAME"], now["CPU_FEATURES"])


@functools.cache
def _processor(name, features):
    given = name
    name = name or llvm.get_host_cpu_name()
    if features is None:
        features = _features(given or name)
    return llvm.get_process_triple(), name, features


def _features(name):
    """The features of the host, as Numba chooses them."""
    if chosen() is not None or name in WITHOUT_AVX:
        import numba  # noqa: F401  # waits for an import in another thread; a submodule's does not
        from numba.core.codegen import get_host_cpu_features

        return get_host_cpu_features()
    try:
        return llvm.get_host_cpu_features().flatten()
    except RuntimeError:
        return ""


def width():
    """Lanes of a vector: two registers of the processor, so that one can wait for the other."""
    return 8 if "+avx" in processor()[2].split(",") else 4


def vector_registers():
    """Registers for vectors of at least four numbers; 0 where vectors have two numbers."""
    features = processor()[2].split(",")
    return 32 if "+avx512f" in features else 16 if "+avx" in features else 0


def target(opt=3):
    """Numba's target machine, but for position-independent code."""
    return _target(*processor(), opt)


@functools.cache
def _target(triple, cpu, features, opt):
    initialise()
    return llvm.Target.from_triple(in_elf(triple)).create_target_machine(
        cpu=cpu, features=features, opt=opt, reloc="pic", codemodel="small"
    )


def in_elf(triple):
    """The triple of object code; on Windows the triple names ELF, which `object_file` can read."""
    return f"{triple}-elf" if "windows" in triple and not triple.endswith("-elf") else triple


def translated(text, symbol, scheduled=False):
    """(object code, needs) of the LLVM text of a module in which `symbol` is a function.

    For `scheduled` text, the only pass turns places on the stack into values (SROA).
    """
    initialise()
    module = llvm.parse_assembly(text, llvm.create_context())  # a shared context never frees memory
    for_machine(module, target())
    for function in module.functions:
        if not function.is_declaration and function.name != symbol:
            function.linkage = "internal"
    if scheduled:
        builder = llvm.create_pass_builder(target(), llvm.create_pipeline_tuning_options(0))
        passes = llvm.create_new_module_pass_manager()
        passes.add_sroa_pass()
        _finish(passes, module, builder)
        return emitted(module, symbol, target(2))
    if max(part.count("\n") for part in text.split("\ndefine ")) > STRAIGHT:
        return emitted(module, symbol, target(0))
    optimise(module)
    return emitted(module, symbol)


def optimise(module, look=None):
    """Numba's two rounds of optimisation, by its settings: a cheap one that inlines, a full one.

    ``look()`` is called after each, and may raise an exception.
    """
    loops = bool(setting("LOOP_VECTORIZE"))
    words = bool(setting("SLP_VECTORIZE"))
    level: Any = setting("OPT")
    highest = getattr(level, "is_opt_max", False)
    _run(module, 3 if highest else 0, loops and highest, False, int(level) != 0)
    if look:
        look()
    _run(module, int(level), loops, words, False)
    if look:
        look()


def _run(module, level, loops, words, prepare):
    tuning = llvm.create_pipeline_tuning_options()
    tuning.speed_level = level
    tuning.loop_vectorization = loops
    tuning.slp_vectorization = words
    builder = llvm.create_pass_builder(target(), tuning)
    passes = builder.getModulePassManager()
    if prepare:
        passes.add_loop_rotate_pass()
        passes.add_instruction_combine_pass()
        passes.add_jump_threading_pass()
    _finish(passes, module, builder)


def _finish(passes, module, builder):
    """Run passes once, and free them.

    llvmlite 0.50 frees no passes: a base class hides the method that would.
    """
    passes.run(module, builder)
    if type(passes)._dispose is ObjectRef._dispose:
        NewPassManager._dispose(passes)


def drop_unused(module):
    """Drop internal symbols that are not used."""
    builder = llvm.create_pass_builder(target(), llvm.create_pipeline_tuning_options(0))
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    _finish(passes, module, builder)


def internal(module, symbol):
    """Make all of a module's symbols internal but one."""
    # A global that is filled in later must not be internal: the optimiser would assume null.
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and not value.name.startswith(PROCESS_BOUND):
            value.linkage = "external" if value.name == symbol else "internal"


def settled(module, symbol):
    """(object code, needs) of Numba's code after optimisation; Unsealable if it needs Python."""
    for value in module.global_variables:
        if ENVIRONMENT in value.name:
            value.linkage = "linkonce_odr"  # LLVM drops such a symbol if it is unused
    drop_unused(module)
    for value in module.global_variables:
        if value.name.startswith(PROCESS_BOUND):
            raise Unsealable(BACK_TO_PYTHON)
    return emitted(module, symbol)


def for_machine(module, machine):
    """Give a module the triple and the layout of data of a machine."""
    module.triple, module.data_layout = machine.triple, str(machine.target_data)


def emitted(module, symbol, machine=None):
    """(object code, needs) of a module with one visible symbol."""
    machine = machine or target()
    for_machine(module, machine)
    code = machine.emit_object(module)
    needs = symbols(code)[1]
    checked(code, symbol, needs)
    for name in needs:
        try:
            provider(name)
        except UnknownSymbol:
            python = name.startswith(("Py", "_Py"))
            reason = BACK_TO_PYTHON if python else f"it calls {name}, which Numba has in a process"
            raise Unsealable(reason) from None
    return code, needs
