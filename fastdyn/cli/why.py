"""The command ``fastdyn why FILE:FUNCTION``: how a function is compiled, and what prevents it."""

import ast
import inspect
import linecache
import os
import re
import textwrap
import warnings

import llvmlite.binding as llvm

from fastdyn.code_store.target import optimise, processor, target
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.recurrences.rewrite import NotSmooth
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.methods import METHODS
from fastdyn.trace.graph.expressions import live

from . import checks, functions

ORDER = 13  # of the Taylor series that is asked for
PLACE = re.compile(r" \((?P<file>[^()]+), line (?P<line>\d+)\)$")
DECIDES = "it decides too often", "it decides in too many ways"  # and so at each of its branches
BRANCHES = (ast.If, ast.IfExp, ast.While, ast.BoolOp)


def add_options(parser):
    """Teach the parser of the command its words."""
    parser.add_argument("function", metavar="FILE:FUNCTION",
                        help="fun(t, y, *args), in a file, which is run, but for what stands below "
                        "`if __name__ == '__main__':`; or METHOD, see `--show`")  # fmt: skip
    functions.add_state(parser)
    parser.add_argument("--show", choices=("llvm", "assembly", "kernel"),
                        help="print the machine code of a traced function, or the step of a "
                        "method, `why --show kernel RK45`")  # fmt: skip


def run(options):
    """Print how a function is compiled; 1 if it stays in Python."""
    if options.show == "kernel":
        print(_kernel(functions.in_a_sentence(checks.method, options.function)))
        return 0
    function, name = functions.named(options.function)
    y0 = functions.state(function, options)
    bound, warned = _bound(function, options.args, options.t, y0)
    attempt = Attempt(function, options.args, DERIVATIVE, len(y0))
    refused = attempt.facts().refusal
    compiled = bound.function
    told = f"t = {options.t:g}, y of {len(y0)}, args = {options.args}"
    if compiled is None:
        print(f"{name} runs in Python ({told}).")
        _tell(warned[0] if warned else refused or "the reason is not known")
        if refused and warned and refused not in warned[0]:
            print("Tracing refused it:")
            _tell(refused, function)
        return 1
    if compiled.traced is None:
        print(f"{name} is compiled by Numba ({told}). Tracing refused it:")
        _tell(refused or "the reason is not known", function)
        return 0
    print(f"{name} is traced ({told}): {_size(compiled.traced)}.")
    if in_batches := attempt.facts(batches=True).refusal:
        print("Its numbers are traced one by one. Tracing in batches refused it:")
        _tell(in_batches, function)
    if not compiled.traced.in_batches:
        try:
            compiled.series(ORDER)
            print("It has a Taylor series.")
        except NotSmooth as reason:
            print(f"It has no Taylor series: {reason}.")
    if options.show:
        print(_machine_code(compiled.traced.text(name.replace(".", "_")), options.show))
    return 0


def _size(traced):
    """The size of a trace, in words."""
    trace = traced.trace
    paths = f"{trace.n_paths} path{'s' * (trace.n_paths > 1)}"
    if traced.in_batches:
        return f"{len(traced.program.order)} batches, {paths}"
    return f"{len(live(trace.outputs))} nodes, {paths}"


def _bound(function, args, t, y0):
    """The function as kernels call it, and the reasons of CompileWarnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        bound = bind(function, args, DERIVATIVE, len(y0), Near(t, t + 1.0, y0, True))
        if bound.callback is not None:
            bound.callback.announce()
    return bound, [str(one.message).partition("slower: ")[2] for one in caught]


def _tell(reason, function=None):
    """Print a reason, and the lines of the user's file that it names, or that branch."""
    place = PLACE.search(reason)
    print(f"  {PLACE.sub('', reason)}")
    if place:
        _tell_line(place["file"], int(place["line"]))
    elif function is not None and reason in DECIDES:
        for file, line in _branches(function):
            _tell_line(file, line)


def _tell_line(file, line):
    print(f"    {os.path.relpath(file)}:{line}: {linecache.getline(file, line).strip()}")


def _branches(function):
    """(file, line) of the branches of a function."""
    function = inspect.unwrap(function)
    try:
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(inspect.cleandoc("\n" + "".join(lines)))
    except (OSError, TypeError, SyntaxError):
        return []
    found = {one.lineno for one in ast.walk(tree) if isinstance(one, BRANCHES)}
    return [(inspect.getfile(function), first + line - 1) for line in sorted(found)]


def _machine_code(text, kind):
    """LLVM's text of a function as the optimiser leaves it, or its assembly."""
    module = llvm.parse_assembly(text, llvm.create_context())
    module.triple, module.data_layout = processor()[0], str(target().target_data)
    optimise(module)
    return str(module) if kind == "llvm" else target().emit_assembly(module)


def _kernel(name):
    """The source of the functions that a loop over steps calls, and of the interpolant."""
    code = METHODS[name].code
    called = [*getattr(code.kernel, "args", ()), code.dense_rows]
    found = [one.py_func for one in called if hasattr(one, "py_func")]
    return "\n".join(textwrap.dedent(inspect.getsource(function)) for function in found)
