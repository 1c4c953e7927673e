"""What is known of an operation of the graph, in one record; everything else reads the records.

The rules of a record are formulas of `Value`, for nodes and for whatever else a graph computes:
`by_rule` applies them.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class Operation(NamedTuple):
    """The record of an operation.

    Attributes
    ----------
    name : str
        The name in the graph; of an elementary function, its name in C.
    value : callable
        The value by NumPy, of numbers or arrays; a node's `data`, if there are any, come first.
    factors : tuple or None
        For each operand the rule ``(result, *operands)`` for the derivative by the operand, or a
        number.  None instead of the tuple: not known.
    llvm : str
        A method of llvmlite's builder, or an intrinsic ("llvm.sqrt"); "": a function of C, or a
        method of `emit.numbers.Emitter`.
    sign : str
        The operator in Python, of arithmetic and comparisons.
    truth, whole, tables, elementary : bool
        Whether the value is a truth value; is a whole number; whether the operation reads tables;
        whether the operation is a function that has formulas on vectors, or comes from C.
    cost : int
        Processor time, in additions.
    in_math : callable, optional
        The function of `math`.
    aliases : tuple of str
        Further names in NumPy and SciPy.
    raises : callable, optional
        ``raises(function of math, result, *operands)``: see `domains`.
    formula : callable, optional
        The rule ``(*operands)`` for the value by other operations: no node has this operation, and
        no more fields are needed.
    recurrence : str
        The recurrence of the Taylor coefficients: "linear", "product", "quotient", "root",
        "choice"; "integral" of slope times derivative of the operand (A. Jorba and M. Zou,
        Experimental Mathematics 14, 2005, section 3); "": no Taylor series.
    series : callable, optional
        The rule ``(*operands)`` for the value by products, powers and functions with shorter
        recurrences.
    slopes : tuple, optional
        `factors` with shorter recurrences, but of less accuracy.
    parity : str
        "even" or "odd".
    width : float, optional
        The width of the transition at 0 beyond which the function is nearly constant, so that a
        Taylor series does not show the transition; 0: nothing of the kind.  None: not known.
    monotone, kinked, root : bool
        Whether the function rises or falls throughout; has a kink; has an infinite slope at 0.
    decision : callable, optional
        The rule ``(result, *operands)`` for a value that changes where the operation jumps.
    inside : callable, optional
        ``inside(result, *operands, slots)`` yields (slot, derivative) for parameters in tables.
    words : str
        The operation in messages.
    """

    name: str
    value: Any = None
    factors: Any = None
    llvm: str = ""
    sign: str = ""
    truth: bool = False
    whole: bool = False
    tables: bool = False
    elementary: bool = False
    cost: int = 1
    in_math: Any = None
    aliases: tuple = ()
    raises: Callable | None = None
    formula: Callable | None = None
    recurrence: str = ""
    series: Callable | None = None
    slopes: Any = None
    parity: str = ""
    width: Any = None
    monotone: bool = False
    kinked: bool = False
    root: bool = False
    decision: Callable | None = None
    inside: Callable | None = None
    words: str = ""


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
