"""The record of an operation of the graph: its derivatives, code, series and names, once.

The rules of a record are formulas of `Value`, for nodes and for whatever else a graph computes:
`by_rule` applies them.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class Operation(NamedTuple):
    """The record of an operation; a rule ``(result, *operands)`` may be a number."""

    name: str  # in the graph; of an elementary function, in C
    value: Any = None  # by NumPy, of numbers or arrays; the `data` of a node come first, if any
    factors: Any = None  # for each operand the rule for the derivative by it; None: not known
    llvm: str = ""  # method of llvmlite's builder, intrinsic; "": function of C, or of `Emitter`
    sign: str = ""  # the operator in Python, of arithmetic and comparisons
    # The operation in source, `{0} % {1}`, of C and of JavaScript: see `emit/source/language.py`;
    # "": by `sign`, or a function of C or of `Math` by the name; None: it has no such form.
    c: str | None = ""
    js: str | None = ""
    truth: bool = False  # the value is a truth value
    whole: bool = False  # the value is a whole number
    tables: bool = False  # the operation reads tables
    elementary: bool = False  # a function from C, or by a formula on vectors
    cost: int = 1  # processor time, in additions
    in_math: Any = None  # the function of `math`
    aliases: tuple = ()  # further names in NumPy and SciPy
    raises: Callable | None = None  # (function of math, result, *operands): see `domains`
    # The rule (*operands) for the value by other operations; then no more fields are needed.
    formula: Callable | None = None
    # Taylor coefficients: "linear", "product", "quotient", "root", "choice"; "integral" of slope
    # times derivative of the operand (A. Jorba and M. Zou, Experimental Mathematics 14, 2005,
    # section 3); "": no Taylor series.
    recurrence: str = ""
    series: Callable | None = None  # rule (*operands) for the value, with shorter recurrences
    slopes: Any = None  # `factors` with shorter recurrences, but of less accuracy
    parity: str = ""  # "even" or "odd"
    # Width of the transition at 0 beyond which the function is nearly constant, so that a Taylor
    # series does not show the transition; 0: nothing of the kind; None: not known.
    width: Any = None
    monotone: bool = False  # rises or falls throughout
    kinked: bool = False
    root: bool = False  # has an infinite slope at 0
    decision: Callable | None = None  # rule for a value that changes where the operation jumps
    inner: bool = False  # the value is no number, but what other operations read
    # The rule (result, *operands) for the derivatives by entries of tables: pairs of a table's name
    # and ((index, derivative), ...) for the entries that are read.
    inside: Callable | None = None
    words: str = ""  # in messages


class _Operations(dict):
    """The records by name; a leaf, or the call of a library, has an empty record."""

    def __missing__(self, name):
        return NOTHING


NOTHING = Operation("")
OPERATIONS: dict[str, Operation] = _Operations()
NAMES: dict[str, str] = {}  # names of functions in NumPy, SciPy and `math`: names in the graph


def add(*records):
    """Make operations known."""
    for record in records:
        OPERATIONS[record.name] = record
        of_numpy = record.value.__name__ if isinstance(record.value, np.ufunc) else record.name
        of_math = record.in_math.__name__ if record.in_math else record.name
        for name in (of_numpy, of_math, *record.aliases):
            NAMES[name] = record.name
