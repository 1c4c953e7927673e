"""Notes on exceptions of a user's function: one sentence about the probable meaning.

The exception stays as it is, with its traceback; SciPy raises it, too.  A row of SENTENCES is a
pattern of the message and a function that makes the sentence, or gives "" where it does not apply.
"""

import linecache
import re
from collections.abc import Callable
from types import MethodType, TracebackType
from typing import Any, NamedTuple

import numpy as np

from .near import did_you_mean
from .user_lines import of_user

TIMES = ("t", "time", "tau")  # names of the time
PARAMETRISED = ("fun(t", "F(t", "velocity(", "force(")  # functions whose parameters are `args`
Y_FIRST = "(y, t"  # of a form: the order of odeint
LONG = 6  # components of a state that is shown


class Raised(NamedTuple):
    """An exception of a function that was called as ``form``, at a time and a state."""

    error: Exception
    who: str  # the function in a sentence
    form: str
    t: float
    y: np.ndarray
    args: tuple
    names: list  # of the arguments of the user's function, as far as they are known
    entered: bool  # whether the function was entered
    values: dict  # of its variables
    failed: str  # the expression that failed, as far as the source is known
    line: str  # its line
    inner: dict  # the variables there

    @property
    def state(self):
        """The name that the function gives its state."""
        return self.names[Y_FIRST not in self.form] if len(self.names) > 1 else "y"

    @property
    def taken(self):
        """The names of the form, without `*args`."""
        return re.findall(r"\*?\w+", self.form.partition("(")[2].replace("*args", ""))

    def mentions(self, name):
        """Whether the line that failed names a variable; True without a source."""
        return not self.line or re.search(rf"\b{re.escape(name)}\b", self.line) is not None


def explain(error, who, form, t, y, fun=None, args=()):
    """Add a note to an exception of ``fun(t, y, *args)``, if its meaning is known, once."""
    outer, inner = _entered(error.__traceback__)
    frame = outer and outer.tb_frame
    raised = Raised(
        error, who, form, t, np.asarray(y), tuple(args),
        argument_names(fun, frame and frame.f_code),
        frame is not None, frame.f_locals if frame else {},
        *_failed(inner), inner.tb_frame.f_locals if inner else {},
    )  # fmt: skip
    said = _sentence(raised)
    if said and said not in getattr(error, "__notes__", ()):
        error.add_note(said)


def argument_names(fun, entered=None):
    """The names of the arguments of a function, or of the code that was entered, without `self`."""
    code = entered or getattr(fun, "__code__", None)
    if code is None:
        return []
    names = [*code.co_varnames[: code.co_argcount]]
    bound = isinstance(fun, MethodType) and code is fun.__code__
    return names[1:] if bound or names[:1] == ["self"] else names


def _sentence(raised):
    swapped = of_odeint(raised.names, raised.who, raised.form)
    if swapped:
        return swapped
    for kinds, pattern, meaning in SENTENCES:
        found = isinstance(raised.error, kinds) and re.search(pattern, str(raised.error))
        if found and (said := meaning(raised, found)):
            return said
    return ""


def _entered(traceback: TracebackType | None) -> tuple[Any, Any]:
    """The first and the last frame of the user's code below the call."""
    found = []
    while traceback is not None:
        if of_user(traceback.tb_frame.f_code.co_filename):
            found.append(traceback)
        traceback = traceback.tb_next
    return (found[0], found[-1]) if found else (None, None)


def _failed(traceback):
    """The expression that failed, and its line; "" without a source."""
    if traceback is None:
        return "", ""
    code = traceback.tb_frame.f_code
    line = linecache.getline(code.co_filename, traceback.tb_lineno)
    places = [*code.co_positions()]
    first, last, begin, end = places[traceback.tb_lasti // 2]
    if first is None or first != last or begin is None or end is None:
        return line.strip(), line
    return line.encode()[begin:end].decode(errors="replace"), line


def of_odeint(names, who="`fun`", form="fun(t, y)"):
    """The sentence about arguments in the order of odeint, (y, t), by their names; or ""."""
    if len(names) > 1 and names[1] == "t" and names[0][0] not in "tT" and Y_FIRST not in form:
        return (
            f"{who} is called as {form}: its first argument, `{names[0]}` here, is the time. "
            "For a function in the order of odeint give lambda t, y: fun(y, t)."
        )
    return ""


def of_solve_ivp(names):
    """The sentence about arguments in the order of solve_ivp, (t, y), by their names; or ""."""
    if names[:2] in (["t", "y"], ["t", "x"]):
        return (
            f"`func` is called as func{Y_FIRST}, *args): its first argument, `t` here, is the "
            "state. For a function of (t, y) give tfirst=True."
        )
    return ""


def _call(raised, found):
    """A call that does not fit: arguments that are missing, or too many."""
    if raised.entered:  # a call within the function
        return ""
    many = len(raised.args)
    given = f"{raised.who} is called as {raised.form}"
    missing = re.findall(r"'(\w+)'", found[0].partition(":")[2])
    owner = found.string.partition("(")[0].rpartition("<locals>.")[2]
    if "." in owner and len(missing) == 1 and not many:
        return f"{given}: is it a method? Give that of an object, as in Pendulum(...).rhs."
    if missing and not raised.form.startswith(PARAMETRISED):
        rest = " and no ".join(missing)
        return f"{given}: it gets no {rest}. A known value goes in as a default, {missing[0]}=..."
    if missing:
        has = f", and `args` has {many} value{'s' if many > 1 else ''}" if many else ""
        rest = ", ".join(missing)
        comma = "," if len(missing) == 1 and not many else ""
        form = f"args=({'..., ' if many else ''}{rest}{comma})"
        return f"{given}{has}: give the value{'s' if len(missing) > 1 else ''} of {rest}, {form}."
    if many and "*args" in raised.form:
        with_ = "value" if many == 1 else f"{many} values"
        return f"{given}, here with the {with_} of `args`; each function of a solve gets them."
    return f"{given}."


def _in_order_of_odeint(raised, found):
    """A time that is taken for the state."""
    if Y_FIRST in raised.form:
        return of_solve_ivp([name[0] for name in raised.names])
    if not raised.entered or not isinstance(raised.values.get(raised.names[0]), float):
        return ""
    first = raised.names[0]
    if first in TIMES or not raised.mentions(first):
        return ""
    return (
        f"{raised.who} is called as {raised.form}: its first argument, `{first}` here, is the "
        f"time. For a function in another order give a lambda: lambda t, y: fun(y, t)."
    )


def _unpacked(raised, found):
    """A state with another number of components than the function takes."""
    n = len(raised.y)
    if found.groupdict().get("size") not in (None, str(n)) or not raised.mentions(raised.state):
        return ""
    return f"`{raised.state}` has {n} component{'' if n == 1 else 's'}, as many as `y0`."


def _short(raised, found):
    """A state with fewer components than the function reads."""
    n = len(raised.y)
    said = _unpacked(raised, found)
    last = f"counted from 0, the last is {raised.state}[{n - 1}]" if n else "it is empty"
    return said and f"{said[:-1]}; {last}."


def _power(raised, found):
    if "^" not in (raised.line or "^"):
        return ""
    return "`^` is no power in Python: x squared is x**2."


def _brackets(raised, found):
    """An index in round brackets, as in MATLAB."""
    name = re.match(r"\w+(?=\()", raised.failed)
    if name is None or not isinstance(raised.inner.get(name[0]), np.ndarray):
        return ""
    return f"Components stand in square brackets and are counted from 0: the first is {name[0]}[0]."


def _one_number(raised, found):
    """A function of one number that gets the whole state."""
    called = re.match(r"\s*(?:\w+\.)*(\w+)\(", raised.failed)
    what = f"`{called[0].strip()[:-1]}` takes" if called else "Functions of `math` and float() take"
    arrays = ", and np." + called[1] if called and hasattr(np, called[1]) else ", and NumPy's"
    if called and called[1] in ("float", "int", "complex"):
        arrays = ""
    does = " takes an array" if called else " functions take arrays"
    arrays = arrays + does if arrays else ""
    return f"{what} one number; here it has an array. One component is {raised.state}[0]{arrays}."


def _truth(raised, found):
    """A condition on the whole state."""
    return (
        f"A condition is about one number, as in `if {raised.state}[0] > 0`; for each component "
        "there is np.where(condition, a, b)."
    )


def _no_numbers(raised):
    """Yield, for each argument that is no number, the argument and its kind, as words."""
    names = raised.names[len(raised.taken) :]
    values = raised.args or [raised.values[name] for name in names if name in raised.values]
    for i, value in enumerate(values):
        name = f"`{names[i]}`" if i < len(names) else f"args[{i}]"
        if i < len(names) and not raised.mentions(names[i]):
            continue
        if value is None or isinstance(value, str):
            yield f"{name} is {'None' if value is None else f'the text {value!r}'}"
        elif isinstance(value, list | tuple | np.ndarray) and np.ndim(value):
            yield f"{name} is {_described(value)}"


def _described(value):
    kind = {list: "a list", tuple: "a tuple"}.get(type(value), "an array")
    return f"{kind} of {np.size(value)} numbers" if np.ndim(value) == 1 else (
        f"{kind} of shape {np.shape(value)}"
    )  # fmt: skip


def _parameters(raised, found):
    """An argument that is no number, where one is meant."""
    said = next(_no_numbers(raised), "")
    return said and f"In `args` {said}; is one number meant?"


def _key(raised, found):
    """A key that a dict of parameters does not have."""
    key = raised.error.args[0] if raised.error.args else None
    for name, value in raised.inner.items():
        if isinstance(value, dict) and key not in value and raised.mentions(name):
            said = did_you_mean(key, [each for each in value if isinstance(each, str)], form="'{}'")
            known = ", ".join(map(repr, value)) or "nothing"
            return f"`{name}` has {known}, but no {key!r}{f'; {said}' if said else '.'}"
    return ""


def _place(raised, found):
    """Where the function has no value: at which time and state."""
    y = np.array2string(raised.y[:LONG], precision=6, separator=", ")
    more = "" if len(raised.y) <= LONG else f" and {len(raised.y) - LONG} more components"
    at = f"{raised.who} was called at t = {raised.t:.10g}, y = {y}{more}."
    if isinstance(raised.error, ValueError) and raised.form.startswith("fun(t"):
        at += " If it is defined for some states alone, give `domain=` or `nonnegative=`."
    return at


FLOAT = r"(?:numpy\.)?float(?:64)?"
WIDE = (
    r"could not be broadcast|inhomogeneous|setting an array element|"
    r"values? (?:in rows, )?for a state|mismatch in its core dimension|can't multiply sequence|"
    r"did not contain a loop|unsupported operand|bad operand|can only concatenate|Cannot cast|"
    r"ufunc '\w+' not supported"
)
SENTENCES: tuple[tuple[Any, str, Callable], ...] = (
    (TypeError, r"missing \d+ required (?:positional|keyword-only) arguments?: .*", _call),
    (TypeError, r"takes (?:from )?\d.* positional arguments? .*w(?:as|ere) given", _call),
    (TypeError, r"bitwise_xor|for \^", _power),
    (TypeError, r"'numpy.ndarray' object is not callable", _brackets),
    (TypeError, rf"'{FLOAT}' object is not (?:subscriptable|iterable)", _in_order_of_odeint),
    (TypeError, rf"non-iterable {FLOAT} object|type '{FLOAT}' has no len", _in_order_of_odeint),
    (ValueError, r"input operand \d does not have enough dimensions", _in_order_of_odeint),
    (IndexError, r"invalid index to scalar|too many indices", _in_order_of_odeint),
    (IndexError, r"is out of bounds for axis 0 with size (?P<size>\d+)", _short),
    (ValueError, r"not enough values to unpack \(expected \d+, got (?P<size>\d+)\)", _unpacked),
    (ValueError, r"too many values to unpack", _unpacked),
    (TypeError, r"only (?:0-dimensional|length-1|size-1) arrays can be converted", _one_number),
    (ValueError, r"truth value of an array with more than one element", _truth),
    ((TypeError, ValueError), WIDE, _parameters),
    (KeyError, r"", _key),
    (ArithmeticError, r"", _place),
    (ValueError, r"math domain error|expected a .* input, got", _place),
)
