"""One pass over Numba's reading of a user's function, before types are inferred.

Numba compiles what the user wrote, with three changes that keep its meaning:

- outside numbers and arrays (globals, closure variables, attributes of `self`) become loads from
  the parameter block, so that their values are never stale and never a reason to recompile;
- plain Python functions that it calls become compiled ones;
- a returned list, or ``np.array`` of a list, becomes a tuple, and an array that is made to be
  returned is the kernel's own (`in_place`): nothing is allocated.

The first argument arrives as three: (argument, block, array for the result or None).
"""

import operator
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numba.core import ir, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.typed_passes import NopythonTypeInference
from numba.core.untyped_passes import InlineClosureLikes
from numba.extending import overload

from fastdyn.compile.captured import (
    MISSING,
    count_definitions,
    draws_random,
    references,
    resolve,
    stored_outside,
    track,
    walks_into,
)
from fastdyn.compile.diagnostics import Uncompilable
from fastdyn.kernels.jit_options import BARE, njit

from .checked_integers import INSTEAD as CONVERSIONS
from .checked_integers import CheckedIntegers
from .return_buffer import return_in_place
from .unbound import guard_unbound
from .vector_check import Guard

ATTRIBUTE = "__fastdyn_plan__"
BLOCK, OUT = "$fastdyn_block", "$fastdyn_out"


class Plan(NamedTuple):
    """What the pass must know of one function.

    `loads` maps a Reference to the compiled function that reads it from the block, `outermost` says
    whether the first argument is three, `tuples` whether returned lists become tuples.
    """

    function: object
    owner: object
    loads: dict
    outermost: bool
    tuples: bool


@register_pass(mutates_CFG=False, analysis_only=False)
class Rewrite(FunctionPass):
    """The pass; functions without a plan are left alone."""

    _name = "fastdyn_rewrite"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        plan = getattr(state.func_id.func, ATTRIBUTE, None)
        if plan is None:
            return False
        blocks = state.func_ir.blocks
        guard_unbound(blocks)
        _replace_powers(blocks)
        _replace_conversions(blocks)
        counts = count_definitions(blocks)
        _replace_outside(blocks, counts, plan)
        if plan.outermost:
            _unpack(blocks)
            made = _made_once(blocks)
            return_in_place(blocks, made, lambda name: _outside_value(name, made), OUT)
        if plan.tuples:
            _return_tuples(blocks)
        state.func_ir._definitions = _definitions(state.func_ir)
        return True


class Compiler(CompilerBase):
    """Numba's pipeline with the pass after closures are inlined."""

    def define_pipelines(self):
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(Rewrite, InlineClosureLikes)
        manager.add_pass_after(Guard, NopythonTypeInference)
        manager.add_pass_after(CheckedIntegers, Guard)
        manager.finalize()
        return [manager]


def power(a, b):
    """a ** b, a real number for whole numbers too: Python's 10 ** -2 is none that an int holds."""
    return a**b


@overload(power, jit_options=BARE)
def _power(a, b):
    if isinstance(a, types.Integer) and isinstance(b, types.Integer):
        return lambda a, b: float(a) ** b
    return lambda a, b: a**b


def _replace_powers(blocks):
    """Send a ** b to `power`, but for constant exponents that are no negative whole numbers."""
    constants = {
        statement.target.name: statement.value.value
        for block in blocks.values()
        for statement in block.find_insts(ir.Assign)
        if isinstance(statement.value, ir.Const)
    }
    for block in blocks.values():
        body = []
        for statement in block.body:
            value = getattr(statement, "value", None)
            if isinstance(value, ir.Expr) and value.op in ("binop", "inplace_binop"):
                exponent = constants.get(value.rhs.name)
                plain = isinstance(exponent, float) or (isinstance(exponent, int) and exponent >= 0)
                if value.fn in (operator.pow, operator.ipow) and not plain:
                    loc = value.loc
                    function = statement.target.scope.redefine("$fastdyn_power", loc)
                    body.append(ir.Assign(ir.Global("power", power, loc), function, loc))
                    call = ir.Expr.call(function, (value.lhs, value.rhs), (), loc)
                    statement = ir.Assign(call, statement.target, loc)
            body.append(statement)
        block.body = body


def _replace_conversions(blocks):
    """Send int(x), round(x) and their kin to the functions that check what they make."""
    made = _made_once(blocks)
    for block in blocks.values():
        for statement in block.find_insts(ir.Assign):
            value = statement.value
            if isinstance(value, ir.Expr) and value.op == "call":
                if len(value.args) != 1 or value.kws or value.vararg is not None:
                    continue
                called = _outside_value(value.func.name, made)
                function = next((ours for his, ours in CONVERSIONS.items() if his is called), None)
                if function is not None:
                    loc = value.loc
                    name = statement.target.scope.redefine("$fastdyn_conversion", loc)
                    at = block.body.index(statement)
                    block.body.insert(at, ir.Assign(ir.Global("whole", function, loc), name, loc))
                    statement.value = ir.Expr.call(name, value.args, (), loc)


def _definitions(func_ir):
    from numba.core.ir_utils import build_definitions

    return build_definitions(func_ir.blocks)


def _replace_outside(blocks, counts, plan):
    from fastdyn.compile.bind import called_function

    changes = {}
    uses = list(track(blocks, counts, plan.owner is not None))
    read_from = {p._replace(attributes=p.attributes[:-1]) for *_, p in uses if p.attributes}
    for block, i, statement, path in uses:
        if path.root == "self" and not path.attributes:
            continue
        value, depth = resolve(path, plan.function, plan.owner)
        if depth < len(path.attributes) or value is MISSING:
            continue
        load = plan.loads.get(path)
        if load is None:
            function = called_function(value)
            if function is not None:
                value = function
            elif walks_into(value) and not isinstance(value, ModuleType) and path in read_from:
                value = None  # an object or class: only what is read from it is needed
            elif not path.attributes or isinstance(value, ModuleType) or callable(value):
                continue
        changes.setdefault(id(block), (block, {}))[1][i] = (statement, load, value)
    for block, found in changes.values():
        body = []
        for i, statement in enumerate(block.body):
            if i not in found:
                body.append(statement)
                continue
            _, load, value = found[i]
            scope, loc = statement.target.scope, statement.loc
            if load is None:
                body.append(ir.Assign(ir.Global("value", value, loc), statement.target, loc))
                continue
            reader = scope.redefine("$fastdyn_load", loc)
            body.append(ir.Assign(ir.Global("load", load, loc), reader, loc))
            call = ir.Expr.call(reader, (scope.get_or_define(BLOCK, loc),), (), loc)
            body.append(ir.Assign(call, statement.target, loc))
        block.body = body


def _unpack(blocks):
    """first = arg(0)  ->  given = arg(0); first = given[0]; block = given[1]; out = given[2]."""
    block = blocks[min(blocks)]
    for i, statement in enumerate(block.body):
        if isinstance(statement, ir.Assign) and isinstance(statement.value, ir.Arg):
            if statement.value.index == 0:
                scope, loc = statement.target.scope, statement.loc
                given = scope.redefine("$fastdyn_given", loc)
                others = [scope.get_or_define(name, loc) for name in (BLOCK, OUT)]
                parts = [
                    ir.Assign(ir.Expr.static_getitem(given, k, None, loc), v, loc)
                    for k, v in enumerate((statement.target, *others))
                ]
                block.body[i : i + 1] = [ir.Assign(statement.value, given, loc), *parts]
                return


def _made_once(blocks):
    """{name: statement} of the variables that are assigned once."""
    counts = count_definitions(blocks)
    return {
        statement.target.name: statement
        for block in blocks.values()
        for statement in block.find_insts(ir.Assign)
        if counts[statement.target.name] == 1
    }


def _return_tuples(blocks):
    """Turn each returned list display into a tuple, and drop np.array around one."""
    made, uses = _made_once(blocks), {}
    for block in blocks.values():
        for statement in block.body:
            for v in statement.list_vars():
                uses[v.name] = uses.get(v.name, 0) + 1
    for block in blocks.values():
        if isinstance(block.terminator, ir.Return):
            _tuple_behind(block.terminator.value.name, made, uses)


def _tuple_behind(name, made, uses):
    # Each variable of the chain is named once where it is made and once where it is used.
    statement = made.get(name)
    if statement is None or uses.get(name, 0) > 2:
        return
    value = statement.value
    if isinstance(value, ir.Var):
        _tuple_behind(value.name, made, uses)
    elif isinstance(value, ir.Expr) and value.op == "cast":
        _tuple_behind(value.value.name, made, uses)
    elif isinstance(value, ir.Expr) and value.op == "build_list":
        statement.value = ir.Expr.build_tuple(value.items, value.loc)
    elif isinstance(value, ir.Expr) and value.op == "call" and len(value.args) == 1:
        function = _outside_value(value.func.name, made)
        plain = all(k == "dtype" and _is_float(v.name, made) for k, v in value.kws)
        inner = made.get(value.args[0].name)
        if function in (np.array, np.asarray) and plain and inner is not None:
            items = getattr(inner.value, "items", None)
            displayed = getattr(inner.value, "op", "") in ("build_list", "build_tuple")
            # list_vars names the argument twice: in args and, as Numba keeps it, in kws or func
            if displayed and items is not None and uses[value.args[0].name] <= 3:
                statement.value = ir.Expr.build_tuple(items, value.loc)


def _outside_value(name, made):
    statement = made.get(name)
    value = statement.value if statement else None
    if isinstance(value, ir.Global | ir.FreeVar):
        return value.value
    if isinstance(value, ir.Expr) and value.op == "getattr":
        return getattr(_outside_value(value.value.name, made), value.attr, None)
    return None


def _is_float(name, made):
    return _outside_value(name, made) in (float, np.float64)


def compile_with(plan, options):
    """A dispatcher of the plan's function that goes through the pass.

    Each plan has a function object of its own: the same code, globals and closure.  Raises
    Uncompilable for a function that assigns to variables outside itself: it would be lost.
    """
    source = plan.function
    if name := stored_outside(source.__code__):
        raise Uncompilable(f"it assigns to `{name}`, a variable outside itself")
    for reference in references(source, plan.owner is not None):
        if draws_random(resolve(reference, source, plan.owner)[0]):
            raise Uncompilable("it draws random numbers, which follow NumPy's seed in Python only")
    clone = type(source)(
        source.__code__, source.__globals__, source.__name__, None, source.__closure__
    )
    clone.__qualname__, clone.__module__ = source.__qualname__, source.__module__
    setattr(clone, ATTRIBUTE, plan)
    return njit(pipeline_class=Compiler, **{**BARE, **options})(clone)


__all__ = ["Plan", "compile_with", "types"]
