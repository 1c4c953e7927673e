"""The command ``fastdyn why FILE:FUNCTION``: how a function is compiled, and what prevents it."""

import argparse
import ast
import contextlib
import inspect
import linecache
import os
import re
import sys
import textwrap
import warnings
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np

from fastdyn.code_store.target import optimise, processor, target
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.recurrences.rewrite import NotSmooth
from fastdyn.compile.traced.known import facts_of
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.methods import METHODS
from fastdyn.trace.graph.expressions import live

from . import checks

LONGEST = 32  # components of a state that are tried where `--y0` is not given
ORDER = 13  # of the Taylor series that is asked for
PLACE = re.compile(r" \((?P<file>[^()]+), line (?P<line>\d+)\)$")
DECIDES = "it decides too often", "it decides in too many ways"  # and so at each of its branches
BRANCHES = (ast.If, ast.IfExp, ast.While, ast.BoolOp)


def add_options(parser):
    """Teach the parser of the command its words."""
    parser.add_argument("function", metavar="FILE:FUNCTION",
                        help="fun(t, y, *args), in a file, which is run, but for what stands below "
                        "`if __name__ == '__main__':`; or METHOD, see `--show`")  # fmt: skip
    parser.add_argument("--t", type=checks.number, default=0.0, metavar="T", help="default 0")
    state = parser.add_mutually_exclusive_group()
    state.add_argument("--y0", type=_numbers, metavar="Y0",
                       help="the state, 1,0; if absent, lengths are tried")  # fmt: skip
    state.add_argument("--n", type=checks.whole(1, checks.MOST_POINTS), metavar="N",
                       help="a state of N components, from 1 to 2")  # fmt: skip
    parser.add_argument("--args", type=_literals, default=(), metavar="ARGS",
                        help="the arguments after t and y, 0.2 or 0.2,[1,2]")  # fmt: skip
    parser.add_argument("--show", choices=("llvm", "assembly", "kernel"),
                        help="print the machine code of a traced function, or the step of a "
                        "method, `why --show kernel RK45`")  # fmt: skip


def run(options):
    """Print how a function is compiled; 1 if it stays in Python."""
    if options.show == "kernel":
        print(_kernel(_in_a_sentence(checks.method, options.function)))
        return 0
    function, name = _function(options.function)
    y0 = _state(function, options)
    bound, warned = _bound(function, options.args, options.t, y0)
    asked = function, options.args, DERIVATIVE, len(y0)
    refused = facts_of(*asked).refusal
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
    if in_batches := facts_of(*asked, batches=True).refusal:
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


def _numbers(text):
    return np.array([checks.number(word) for word in text.split(",")])


def _literals(text):
    """The tuple that Python reads in ``0.2,[1,2]``."""
    try:
        return ast.literal_eval(f"({text},)")
    except (ValueError, SyntaxError):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no list of numbers and other literals of Python, such as 0.2,[1,2]."
        ) from None


def _function(text):
    """The function that FILE:FUNCTION names, and its name."""
    path, colon, name = text.rpartition(":")
    if not colon:
        raise ValueError(f"give FILE:FUNCTION, such as {_example(text)}; got {text!r}.")
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))  # as `python FILE` does
    return _in_a_sentence(checks.function_in_file, Path(path), name), name


def _example(text):
    """FILE:FUNCTION of a file, which is read and not run."""
    path = Path(text)
    if path.is_file():
        with contextlib.suppress(SyntaxError, ValueError):
            for one in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(one, ast.FunctionDef):
                    return f"{text}:{one.name}"
    return "orbit.py:satellite"


def _in_a_sentence(check, *given):
    """The result of a check; argparse words a refusal only while it parses."""
    try:
        return check(*given)
    except argparse.ArgumentTypeError as error:
        raise ValueError(str(error)) from None


def _state(function, options):
    """The state that is given, or one of a length for which the function returns as many numbers.

    Raises ValueError where the function does not take the arguments or gives no derivative.
    """
    try:
        inspect.signature(function).bind(options.t, None, *options.args)
    except TypeError as error:
        raise ValueError(f"{error}: `--args` gives the arguments after t and y.") from None
    given = options.y0 if options.n is None else np.linspace(1.0, 2.0, options.n)
    sizes = [len(given)] if given is not None else range(1, LONGEST + 1)
    reasons = []
    for n in sizes:
        y = 1.0 + 0.1 * np.arange(n) if given is None else given
        try:
            size = np.size(function(options.t, y.copy(), *options.args))
        except Exception as error:
            reasons.append(f"it raises {error!r}")
            continue
        if size == n:
            return y
        reasons.append(f"it returns {size} numbers for {n} components")
    advice = "" if given is not None else "; give a state, `--y0`"
    raise ValueError(f"the function gives no derivative: {reasons[0]}{advice}.")


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
