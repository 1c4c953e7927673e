"""Python text from expressions: what a person would have written, and the function it makes."""

import math
import re
from typing import Any

import numpy as np
import sympy as sp
from sympy.printing.codeprinter import PrintMethodNotImplementedError
from sympy.printing.pycode import PythonCodePrinter

from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.kernels.algebra.linear import solve_linear
from fastdyn.trace.written import function_of

SOLVERS = {"solve_linear": solve_linear, "constrained": constrained}
FUNCTIONS = (
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt copysign"
).split()
NUMBERS = {name: getattr(math, name) for name in FUNCTIONS}
ARRAYS = {name: getattr(np, name) for name in FUNCTIONS}
RESERVED = {*FUNCTIONS, *SOLVERS, "abs", "min", "max", "range"}  # names in the text


class _Printer(PythonCodePrinter):
    """Python's operators and the names of `FUNCTIONS`."""

    def __init__(self):
        super().__init__({"fully_qualified_modules": False, "strict": True})

    def _print_sign(self, e):
        return f"copysign(1.0, {self._print(e.args[0])})"

    def _print_Exp1(self, expr):
        return repr(math.e)

    def _print_Pi(self, expr):
        return repr(math.pi)

    def _print_Rational(self, expr):
        exact = expr.q & (expr.q - 1) == 0
        return repr(expr.p / expr.q) if exact else f"{expr.p}/{expr.q}"


def printed(expression):
    """An expression as Python text; ValueError for a function that fastdyn does not compile."""
    for function in expression.atoms(sp.Function):
        name = type(function).__name__
        if name not in {*FUNCTIONS, "Abs", "sign", "Piecewise", "Min", "Max"}:
            raise ValueError(f"`{name}` in `{function}` is no function that fastdyn compiles.")
    try:
        text = str(_Printer().doprint(expression))
    except PrintMethodNotImplementedError as error:
        found = str(error).splitlines()[0]
        raise ValueError(f"`{expression}` cannot be written in Python: {found}") from None
    return re.sub(r"(?<!\w)\((-?\d+\.\d+)\)", r"\1", text)


def real_text(expression):
    """As `printed`; a whole number alone as a float."""
    return repr(float(expression)) if expression.is_Integer else printed(expression)


def function(name, arguments, lines, arrays=False) -> Any:
    """
    The function of a text.

    Parameters
    ----------
    name : str
    arguments : sequence of str
    lines : sequence of str
        Its body.
    arrays : bool
        Whether its functions are NumPy's, for many states at once.
    """
    text = f"def {name}({', '.join(arguments)}):\n" + "".join(f"    {line}\n" for line in lines)
    space: dict[str, Any] = (
        {"__name__": "fastdyn.derive.derived"} | SOLVERS | (ARRAYS if arrays else NUMBERS)
    )
    made = function_of(text, name, "derived", space)
    made.text = text
    return made
