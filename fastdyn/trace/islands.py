"""Islands: functions of NumPy and SciPy that compiled code calls, once in each evaluation.

The graph computes the numbers that go into the call, and uses the numbers that the call returns.
The address of an island is a parameter of the code.  The last output of an island is its failure
flag: 1 if the library raised, or returned something of another form than at first.
"""

import contextlib
import ctypes
import itertools
from typing import Any, NamedTuple

import numpy as np

from .graph.evaluate import evaluate
from .graph.rows import ID, PAIR
from .graph.user_lines import line_of_call
from .symbols.symbol import DTYPES, HANDLERS, Symbol, graph_of, refuse, wrap

CALL = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
MAX_NUMBERS, MAX_ISLANDS = 20_000, 64  # of an island's inputs and of its results; of a function
OBJECTS = {np.dtype(object)}
PLAIN = type(None), bool, int, float, complex, str, slice, np.generic, np.dtype, np.ndarray, type


class Address(float):
    """An address as a float, which is exact; the attribute `of` keeps the Island alive."""

    of: Any


class Part(NamedTuple):
    """A number or an array among the inputs or the outputs: its place, and zeros like it."""

    begin: int
    end: int
    like: Any
    py: bool = False

    def read(self, numbers):
        found = np.empty_like(self.like)
        found[...] = numbers[self.begin : self.end].view(found.dtype).reshape(found.shape)
        return found.item() if self.py else found[()]

    def write(self, value, numbers):
        array = np.asarray(value)
        if (array.dtype, array.shape) != (self.like.dtype, self.like.shape):
            raise TypeError("a library gives numbers of another form than before")
        numbers[self.begin : self.end] = np.ravel(array).view(float)

    def symbol(self, g, ids):
        kind = self.like.dtype.kind
        part = ids[self.begin : self.end].view(PAIR if kind == "c" else ID)
        if not self.like.ndim:
            return wrap(g, part[0], kind, self.py)
        moved = np.empty_like(self.like, part.dtype)
        moved[...] = part.reshape(moved.shape)
        return Symbol(g, moved, kind)


def nested(function, value) -> Any:
    """A value with ``function(part)`` in place of each part that is no list, tuple or dict."""
    if isinstance(value, dict):
        return {name: nested(function, each) for name, each in value.items()}
    if isinstance(value, list | tuple) and not isinstance(value, Part):
        make: Any = getattr(type(value), "_make", tuple if isinstance(value, tuple) else list)
        return make([nested(function, each) for each in value])
    return function(value)


def leaves(value):
    """The parts of a value that are no list, tuple or dict."""
    found: list = []
    nested(found.append, value)
    return found


class Given:
    """The arguments of a call: the `ids` of their numbers; `key` identifies all else."""

    def __init__(self, args, kwargs):
        self.ids, self.size, self._key = [], 0, []
        self._parts = nested(self._part, (args, kwargs))
        self.key = repr(nested(type, (args, kwargs))), *self._key

    def of(self, numbers):
        return nested(lambda v: v.read(numbers) if isinstance(v, Part) else v, self._parts)

    def _part(self, value: Any):
        if type(value) is Symbol and (value.varies or value.kind not in "bi"):
            return self._place(value)
        value = value.plain() if type(value) is Symbol else value
        value = getattr(value, "plain", value) if isinstance(value, type) else value
        if not isinstance(value, PLAIN) or getattr(value, "dtype", None) in OBJECTS:
            refuse(f"an object of type {type(value).__name__} is given to a library")
        many = isinstance(value, np.ndarray)
        value = np.array(value) if many else value
        shape = (value.shape, value.strides, value.dtype.str) if many else ()
        self._key.append((type(value), *shape, value.tobytes() if many else repr(value)))
        return value

    def _place(self, s):
        if s.kind in "bi":
            refuse("whole numbers or truth values that depend on the state are given to a library")
        ids = np.array(s.ids, ID) if not s.many else np.ascontiguousarray(s.ids).view(ID)
        like = np.zeros_like(s.ids if s.many else 0.0, DTYPES[s.kind])
        self.ids.append(ids.reshape(-1))
        self.size += ids.size
        self._key.append((like.shape, like.strides, s.kind, s.py))
        return Part(self.size - ids.size, self.size, like, s.py)


class Result:
    """The form of what a library returns, which no call may change."""

    def __init__(self, value):
        self.size = 0
        self.parts = nested(self._part, value)

    def _part(self, value):
        if isinstance(value, bool | int | np.bool_ | np.integer | str | None):
            return value
        like = np.zeros_like(value)
        if like.dtype not in (float, complex):
            what = f"{like.dtype} array" if like.ndim else type(value).__name__
            raise TypeError(f"a library gives an object of type {what}")
        begin = self.size
        self.size += like.size * (1 + (like.dtype == complex))
        return Part(begin, self.size, like, type(value) in (float, complex))

    def store(self, value, numbers):
        """Copy the numbers of a result; raise TypeError or ValueError if its form is another."""
        for part, now in zip(leaves(self.parts), leaves(value), strict=True):
            if isinstance(part, Part):
                part.write(now, numbers)
            elif type(now) is not type(part) or now != part:
                raise TypeError("a library gives another constant than before")


class Island:
    """A library function in compiled code, with the arguments `given` and the form of its result.

    `place` is the (file, line) of the first call in the user's code.  `exception` is an interrupt
    that stopped the function, for the caller of the compiled code to raise.  `inside`, `pending`
    and `later` are those of a `Callback`, because a solve treats both alike.
    """

    def __init__(self, function, given, result, name):
        self._function, self._given, self._result = function, given, result
        self.name, self.place = name, line_of_call()
        self.n_in, self.n_out = given.size, result.size
        self.exception: Any = None
        self.inside, self.pending, self.later = False, None, float
        self._called = CALL(self._call)
        self.address = Address(ctypes.cast(self._called, ctypes.c_void_p).value or 0)
        self.address.of = self

    def compute(self, numbers, out):
        """Call the library with `numbers`, and store the results in `out`."""
        args, named = self._given.of(numbers)
        with np.errstate(all="ignore"):
            result = self._function(*args, **named)
        self._result.store(result, out)
        out[-1] = 0.0

    def values(self, args):
        """The outputs for numbers or arrays: one row for each output, the failure flag last."""
        points = np.broadcast_arrays(*[np.asarray(a, float) for a in args])
        found = np.ones((points[0].size, self.n_out + 1))
        for k in range(points[0].size):
            with contextlib.suppress(Exception):
                self.compute(np.array([p.flat[k] for p in points]), found[k])
        return found.T.reshape(self.n_out + 1, *points[0].shape)

    def _call(self, given, out):
        try:  # the compiled code has set the failure flag already
            self.inside = True
            if self.pending is not None:
                interrupt, self.pending = self.pending, None
                interrupt()
            sizes = (given, self.n_in), (out, self.n_out + 1)
            rooms: Any = [(ctypes.c_double * n).from_address(at) for at, n in sizes]
            self.compute(*map(np.frombuffer, rooms))
        except Exception:
            pass
        except BaseException as error:
            self.exception = error
        self.inside = False


def island(function, args, kwargs) -> Any:
    """``function(*args, **kwargs)``, called from the code.

    The library function must have no side effects, and its value depends on its arguments only.
    """
    name = getattr(function, "__name__", type(function).__name__)
    g = graph_of(*args, *kwargs.values())
    if g is None or g.start is None:
        refuse(f"it calls {name}")
    if any(kwargs.get(each) is not None for each in ("out", "output")):
        refuse(f"{name} with an array for its result")
    if any(v is not False for k, v in kwargs.items() if k.startswith("overwrite")):
        refuse(f"{name} that overwrites what it is given")
    if g.in_handler():
        refuse(f"{name} where what it raises is caught")
    given = Given(args, kwargs)
    ids = np.concatenate([np.zeros(0, ID), *given.ids])
    key = "island", function, given.key
    known = g.kept.get(key)
    if known is None:
        if len(g.islands) >= MAX_ISLANDS:
            refuse("it calls a library in too many ways", final=True)
        result = _first(g, function, given, ids, name)
        if max(given.size, result.size) > MAX_NUMBERS:
            refuse(f"{name} of {max(given.size, result.size)} numbers", final=True)
        made = Island(function, given, result, name)
        known = g.kept[key] = made, result
    made, result = known
    row = g.reads.step(g.reads.root(0), "island", made)
    (slot,) = g.reads.parameters(row, made.address)
    g.islands[slot] = made
    data = slot, made.n_in, made.n_out
    if g.few < np.inf:
        found = g.ids(g.row("island", (made.n_out + 1,), (ids,), ("island", *data)))
    else:
        whole = g.make("island", [g.node(i) for i in ids.tolist()], data)
        found = np.array([g.make("entry", (whole,), i).key for i in range(made.n_out + 1)], ID)
    g.raises_if(g.negation(g.compare(g.node(int(found[-1])), g.const(0.0), "eq")), lambda: None)
    return nested(lambda v: v.symbol(g, found) if isinstance(v, Part) else v, result.parts)


def _first(g, function, given, ids, name):
    """The form of the result at the start, or else for random inputs in [0.5, 1.5)."""
    tries, error = [np.random.default_rng(0).uniform(0.5, 1.5, given.size)], None
    if g.few == np.inf:  # numbers of rows are not known yet
        t, y = g.start
        nodes = [g.node(i) for i in ids.tolist()]
        at = np.resize(np.asarray(y, float), (g.state.size, 1))
        tries.insert(0, evaluate(g, nodes, np.array([t]), at, g.values)[0][:, 0])
    for numbers in tries:
        args, kwargs = given.of(numbers)
        try:
            with np.errstate(all="ignore"):
                found = function(*args, **kwargs)
        except Exception as raised:
            error = error or raised
            continue
        try:
            result = Result(found)
        except TypeError as other:
            refuse(str(other))
        pairs = itertools.product(leaves(found), leaves([args, kwargs]))
        if any(np.may_share_memory(a, b) for a, b in pairs if isinstance(a, np.ndarray)):
            refuse(f"a view that {name} gives")
        return result
    return refuse(f"{name} raises {type(error).__name__} at the start", final=True)


def raise_interrupts(islands):
    """Raise the interrupt that stopped one of the islands, if any."""
    found = [each.exception for each in islands if each.exception is not None]
    for each in islands:
        each.exception = each.pending = None
    if found:
        raise found[0]


def islands_of(bounds):
    """The islands that bound functions call, found among the values of their parameters."""
    return [value.of for bound in bounds for _, value in bound.values if type(value) is Address]


HANDLERS["island"] = island
