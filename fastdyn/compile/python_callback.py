"""A function that runs in Python, called from compiled kernels.

Kernels run without the interpreter lock; ctypes takes the lock for each call.  An exception cannot
cross compiled code: the Callback keeps the exception and marks the block, and
`run.laid_out.raise_kept` raises the exception again.
"""

import ctypes
import struct
from typing import Any

import numpy as np

from fastdyn.kernels.algebra.linear import SingularMatrixError
from fastdyn.words.kinds import noted, shown
from fastdyn.words.raised import explain

from .function_convention import SIGNATURE, mark
from .mode import DERIVATIVE, Mode
from .sentences import WritesToState

FLOAT = np.dtype(float)

FORMS = {"F": "F(t, y, yp, *args)", "velocity": "velocity(t, p, *args)"}
FORMS["force"] = "force(t, q, *args)"
MOST_PLACES = 1000  # addresses of states and results whose arrays are kept
FORMS_OF_CODE: dict = {}  # arguments of functions that stand for others, by their code
SPARSE = "`jac` is sparse here and now, and was not before, or is not taken: return arrays."


class OtherShape(ValueError):
    """The result of a function has another shape than the state."""


class OtherRows(OtherShape):
    """The result of a function has as many numbers as the state, in a column or a row."""


class OtherMatrix(OtherShape):
    """A Jacobian has another shape than (n, n), or than its band."""


class Held:
    """The function and the arguments that a Bound was given last, kept alive for its block.

    Between solves, a run that is kept holds None and ().

    Attributes
    ----------
    fun : callable, or the matrix of a constant Jacobian
    args : tuple
    values : tuple or None
        The values of the parameters by group, if `rebind` has read them.
    memory : list
        Other objects that the words of the block point to.
    """

    __slots__ = ("args", "fun", "memory", "values")

    def __init__(self, fun: Any = None, args: Any = ()):
        self.take(fun, args)

    def take(self, fun, args, values=None):
        """Hold another function and other arguments, and nothing of those before."""
        self.fun = fun
        self.args = args
        self.values = values
        self.memory: list = []


class Callback:
    """A C function that calls ``fun(t, y)``; `exception` keeps what `fun` raised.

    Set `writes` to False if writes of `fun` to the state must raise WritesToState, to None if they
    have no effect.  Set `after` to a function that is to be called after each call.

    Parameters
    ----------
    fun : callable
    mode : Mode
    n : int
    announce : callable, optional
        Called once, after the first call that returns a value.
    n_out : int, optional
        Number of results, if the mode does not determine it.

    Attributes
    ----------
    account : budget.Account or None
        The account of a function that waits for its code.
    raises : callable or None
        Called with an exception that `fun` raises.
    """

    account: Any = None
    raises: Any = None

    def __init__(self, fun, mode, n, announce=None, n_out=None):
        self.exception = None
        self.inside = False
        self.pending = None
        self.writes: Any = True
        self.after: Any = None
        self.later: Any = np.float64
        self._fun = fun
        self._mode = mode
        self._states = {}
        self._results = {}
        self._of = getattr(fun, "of", None) if mode is DERIVATIVE else None
        self._announcement = announce
        self._n_out = n_out or mode.n_results(n)
        self._pack = struct.Struct(f"{self._n_out}d").pack_into
        self.begin()
        self._function = SIGNATURE(self._call)
        self.address: Any = ctypes.cast(self._function, ctypes.c_void_p).value

    def begin(self):
        """Begin a solve: the first time is passed as a float, as in SciPy."""
        self._time = np.float64 if self._mode.acts_at_events else float

    def announce(self):
        """Tell the user, once, that the function runs in Python."""
        if self._announcement is not None:
            said = self._announcement
            self._announcement = None
            said()

    def _written(self, state, given):
        """React to a function that has written to its y: raise, copy y to the state, or ignore."""
        if self.writes is False:
            raise WritesToState(begun=True)
        if self._mode.acts_on_state and self.writes:
            state[:] = given

    def _result(self, address):
        """The numbers of the result at an address, as an array and as memory."""
        found = self._results[address] = _numbers_at(self._results, address, self._n_out)
        return found

    def _state(self, address, n):
        """The state of n numbers at an address: n, the array, and how it is copied and compared."""
        array, _ = _numbers_at(self._states, address, n)
        found = self._states[address] = n, array, array.copy, array.tobytes
        return found

    def _value(self, t, y):
        """The value of the function, checked; most values need a look at their types alone."""
        of = self._of
        if of is None:
            return evaluate(self._fun, self._mode, t, y)
        try:
            try:
                value = of.fun(t, y, *of.args)
            except SingularMatrixError as error:
                raise singular_at(t, error) from error
            kind = value.__class__
            if kind is list or kind is tuple:
                for number in value:
                    if number.__class__ is not float and number.__class__ is not np.float64:
                        break
                else:
                    if len(value) == self._n_out:
                        return value
            elif kind is np.ndarray and value.dtype is FLOAT and value.shape == y.shape:
                return value
            return derivative(value, len(y))
        except Exception as error:
            explained(error, self._fun, self._mode.argument, t, y)
            raise

    def _call(self, result, exception, t, y, n, block, out):
        try:
            target, memory = self._results.get(out) or self._result(out)
            if self.exception is not None:  # it waits: no number of this function may be used
                mark(block)
                target[:] = np.nan
                return 0
            self.inside = True
            if self.pending is not None:
                self.pending()
            length, state, copied, as_bytes = self._states.get(y) or self._state(y, n)
            if length != n:
                _, state, copied, as_bytes = self._state(y, n)
            given = copied()  # because the function may keep it
            value = self._value(self._time(t), given)
            if value.__class__ is np.ndarray:
                target[:] = value
            else:  # in a third of the time
                self._pack(memory, 0, *value)
            self._time = self.later
            if given.tobytes() != as_bytes():
                self._written(state, given)
            if self._announcement is not None:
                self.announce()
            if self.after is not None:
                self.after()
            self.inside = False
        except BaseException as error:
            self.inside = False
            self.exception = error
            mark(block)
            self._result(out)[0][:] = np.nan
            if self.raises is not None:
                self.raises(error)
        return 0


def _numbers_at(kept, address, n):
    """n numbers at an address, as an array and as memory, for a table that has room for them."""
    if len(kept) > MOST_PLACES:
        kept.clear()
    memory = (ctypes.c_double * n).from_address(address)
    return np.frombuffer(memory), memory


def numbers_at(address, n):
    """The n numbers at an address, as an array, in a tenth of the time of `np.ctypeslib`."""
    return np.frombuffer((ctypes.c_double * n).from_address(address))


def called_with(fun, args):
    """``fun(t, y, *args)`` as a function of t and y; `args` are kept for sentences."""

    def called(t, y):
        return fun(t, y, *args)

    called.of = Held(fun, args)  # pyright: ignore
    return called


def evaluate(fun, mode, t, y):
    """Call ``fun(t, y)`` in Python; check the value, and return it as an array of real numbers.

    An exception gets a note, if it is known what it means.
    """
    try:
        return _value_of(fun, mode, t, y)
    except Exception as error:
        explained(error, fun, mode.argument, t, y)
        raise


def value_of(fun, args, name, t, y):
    """Return ``fun(t, y, *args)``, unchecked; an exception gets its note."""
    try:
        return fun(t, y, *args)
    except Exception as error:
        explained(error, called_with(fun, args), name, t, y)
        raise


def explained(error, fun, name, t, y):
    """Add the note of `words.raised` to an exception of the argument of a name."""
    who = "An event" if name == "event" else f"`{name}`"
    held = getattr(fun, "of", None) or Held()
    called = held.fun
    args = held.args
    of_code = FORMS_OF_CODE.get(getattr(called, "__code__", None), "t, y, *args")
    form = getattr(called, "form", of_code)
    form = f"{name}({form})" if form != "t, y, *args" else FORMS.get(name, f"{name}({form})")
    explain(error, who, form, t, y, called, args)


def _called(fun, t, y):
    """Call ``fun(t, y)``; the error of a singular matrix tells the time."""
    try:
        return fun(t, y)
    except SingularMatrixError as error:
        raise singular_at(t, error) from error


def singular_at(t, error):
    """The error of a singular matrix, with the time."""
    return SingularMatrixError(f"At t = {t:.10g}, {error}.")


def _value_of(fun, mode, t, y):
    n = len(y)
    if mode.complex_numbers:
        y = y.view(complex)
    if mode.one_number:
        value = np.asarray(fun(t, y))
        if value.size != 1 or value.dtype.kind not in "fiub":
            error = TypeError if value.size == 1 else ValueError
            raise error(f"an event returned {value!r}; it must return one real number")
        return value.reshape(1)
    if mode.matrix:
        return matrix(fun(t, y), n).reshape(-1)
    if mode.entries:
        return fun(t, y)
    if mode.moments:
        own = y[: n // mode.n_copies]
        rates = [own * own if moment == "rms" else own for moment in mode.moments]
        return np.concatenate([evaluate(fun, DERIVATIVE, t, own), *rates])
    if mode.second_order:
        y = np.concatenate([y, np.zeros(n)])
    value = derivative(_called(fun, t, y[:, None] if mode.column else y), len(y), mode)
    if mode.complex_numbers:
        return value.astype(complex).view(float)
    return value[len(y) - n :]


def is_sparse(matrix):
    """Whether a matrix is one of scipy.sparse."""
    return hasattr(matrix, "tocsc")


def check_shape(matrix, n, name="jac"):
    """Raise ValueError unless a matrix has shape (n, n)."""
    if matrix.shape != (n, n):
        raise OtherMatrix(
            f"`{name}` is expected to have shape {(n, n)}, but actually has {matrix.shape}."
        )


def matrix(value, n):
    """A Jacobian as an (n, n) array of floats; ValueError for any other value."""
    if is_sparse(value):
        raise ValueError(SPARSE)
    array = np.asarray(value, dtype=float)
    check_shape(array, n)
    return array


def derivative(value, n, mode: Mode = DERIVATIVE):
    """The user's derivative as an array of n floats; TypeError or ValueError for other values."""
    name = mode.argument
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise noted(error, _uneven(name, value, n)) from None
    if value is None or array.dtype.kind not in "fiubc":
        error = ValueError if array.dtype.kind in "US" else TypeError
        if array.dtype.kind == "O" and not any(v is None for v in array.flat):
            try:  # objects may be numbers of another library
                return derivative(array.astype(float), n, mode)
            except (TypeError, ValueError) as reason:
                error = type(reason)
        without = ": without a `return`, a function returns None" if value is None else ""
        raise error(
            f"`{name}` returned {shown(value)}; it must return {n} number{'s' * (n != 1)}, as a "
            f"list, tuple or array{without}"
        )
    if array.dtype.kind == "c" and not mode.complex_numbers:
        raise TypeError(
            f"`{name}` returned complex numbers"
            + ("; give a complex `y0` to solve for them" if name == "fun" else "")
        )
    if array.ndim == 2 and array.shape == (n, 1) and n > 1 and not mode.column:
        raise OtherRows(
            f"`{name}` returned a column, of shape {array.shape}; it must return one of shape "
            f"({n},), unless `vectorized` is set"
        )
    if array.size != n or (array.ndim > 1 and array.shape != (n, 1)):
        of = "`q0` and `p0`" if mode.half is not None else "`y0`"
        wanted = f"it must return one for each component of {of}"
        if array.ndim > 1:
            product = ": is A @ y meant, and not A * y?" if array.shape == (n, n) else ""
            other = OtherRows if array.size == n else OtherShape
            raise other(
                f"`{name}` returned an array of shape {array.shape}, {array.size} values in rows, "
                f"for a state of {n}; {wanted}, in one row of shape ({n},){product}"
            )
        raise OtherShape(
            f"`{name}` returned {array.size} value{'s' * (array.size != 1)} for a state of {n}; "
            f"{wanted}"
        )
    return array.reshape(n)


def _uneven(name, value, n):
    """The sentence about a derivative whose components have different shapes."""
    for i, each in enumerate(value):
        if np.ndim(each):
            return (
                f"Component {i} of what `{name}` returned has shape {np.shape(each)}; each is one "
                "number, as y[0] is one of y."
            )
    return f"`{name}` must return {n} number{'s' * (n != 1)}."
