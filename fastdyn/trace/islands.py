"""Islands: functions of NumPy and SciPy that compiled code calls, once in each evaluation.

Nodes of the graph compute the numbers that go into the call, and use the numbers that the call
returns.  The address of an island is a parameter of the code.  The last output of an island is its
failure flag: 1 if the library raised, or returned something of another form than at first.
"""

import contextlib
import ctypes
import pickle
from typing import Any, NamedTuple

import numpy as np

from .graph.evaluate import evaluate
from .graph.kinds import INT, NUMPY
from .graph.refusal import LATEST, OutOfTime, Refusal
from .graph.user_lines import line_of_call
from .symbols.arrays import Array, elementwise
from .symbols.complex_pair import Pair, any_complex
from .symbols.layout import arrays_in, laid_out
from .symbols.lazy import complete
from .symbols.real import Symbol, symbol
from .symbols.symbolic import BATCHES, Batched, Symbolic, graph_of, is_symbolic, refuse

CALL = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
MOST_NUMBERS, MOST_ISLANDS = 20_000, 64  # of an island's inputs and of its results; of a function
PLAIN = type(None), bool, int, float, complex, str, slice, np.generic, np.dtype, np.ndarray, type


class Address(float):
    """An address as a float, which is exact; the attribute `of` keeps the Island alive."""

    of: Any


class Part(NamedTuple):
    """A number or an array among the inputs or the outputs: its place, and zeros like it."""

    begin: int
    end: int
    like: np.ndarray

    def read(self, numbers):
        found = np.empty_like(self.like)
        found[...] = numbers[self.begin : self.end].view(found.dtype).reshape(found.shape)
        return found[()]

    def write(self, value, numbers):
        array = np.asarray(value)
        if (array.dtype, array.shape) != (self.like.dtype, self.like.shape):
            raise TypeError("a library gives numbers of another form than before")
        numbers[self.begin : self.end] = array.reshape(-1).view(float)

    def of(self, found):
        """The symbols of a result, in an array of the symbols of all outputs."""
        found, shape = found[self.begin : self.end].copy(), self.like.shape
        if self.like.dtype == complex:
            both = found[::2], found[1::2]
            together = BATCHES["joint"] if isinstance(found, Batched) else None
            found = together(*both) if together else elementwise(Pair, *both)
        return laid_out(found.reshape(shape), self.like) if shape else found[0]


def nested(function, value) -> Any:
    """A value with ``function(part)`` in place of each part that is no list and no tuple."""
    kind: Any = type(value)
    if kind in (list, tuple) or (hasattr(kind, "_make") and kind is not Part):
        return getattr(kind, "_make", kind)([nested(function, v) for v in value])
    return function(value)


class Given:
    """The arguments of a call: `numbers` are the symbols in them, `args` has Parts in their place.

    `size` counts real numbers.
    """

    def __init__(self, args):
        self.numbers, self.size = [], 0
        self.args = nested(self._part, complete(args))

    def _part(self, value: Any):
        value = complete(value)
        value = getattr(value, "plain", value) if isinstance(value, type) else value
        if not is_symbolic(value):
            value = np.array(value.tolist()) if isinstance(value, Array) else value
            if not isinstance(value, PLAIN):
                refuse(f"an object of type {type(value).__name__} is given to a library")
            return value
        array = value if isinstance(value, Batched) else Array.of(value)
        flat = [] if isinstance(value, Batched) else list(array.flat)
        if any(getattr(v, "kind", NUMPY) == INT or is_truth(v) for v in flat):
            refuse("whole numbers or truth values that depend on the state are given to a library")
        like = np.zeros_like(value.ids if not flat else array.view(np.ndarray), float)
        if any_complex(array):
            like, array = like + 0j, np.stack([np.real(array), np.imag(array)], axis=-1)
        self.numbers.append(array.reshape(-1))
        self.size += array.size
        return Part(self.size - array.size, self.size, like)


def is_truth(value):
    return isinstance(value, Symbolic) and not isinstance(value, Symbol | Pair)


class Island:
    """A library function in compiled code.

    `place` is the (file, line) of the first call in the user's code.  `exception` is an interrupt
    that stopped the function, for the caller of the compiled code to raise.  `inside`, `pending`
    and `later` are those of a `Callback`, because a solve treats both alike.
    """

    def __init__(self, key, name, start):
        self._function, self._args, self._names, self.n_in = pickle.loads(key)
        self.name, self.place, self.n_out = name, line_of_call(), 0
        self.result = nested(self._part, self._first(start))
        self.exception: Any = None
        self.inside, self.pending, self.later = False, None, float
        self._called = CALL(self._call)
        self.address = Address(ctypes.cast(self._called, ctypes.c_void_p).value or 0)
        self.address.of = self

    def _first(self, start):
        """The result for the inputs at the start, or else for random inputs in [0.5, 1.5)."""
        error: Any = None
        for numbers in (start, np.random.default_rng(0).uniform(0.5, 1.5, self.n_in)):
            try:
                if numbers is not None:
                    return self._result(numbers, True)
            except Exception as raised:
                error = error or raised
        return refuse(f"{self.name} raises {type(error).__name__} at the start", final=True)

    def _part(self, value):
        if np.asarray(value).dtype not in (float, complex) or self.n_out > MOST_NUMBERS:
            refuse(f"{self.name} gives something else than numbers, or too many", final=True)
        like = np.zeros_like(value)
        self.n_out += like.view(float).size if like.shape else like.itemsize // 8
        return Part(self.n_out - like.size * like.itemsize // 8, self.n_out, like)

    def _result(self, numbers, at_first=False):
        args, values = nested(lambda v: v.read(numbers) if isinstance(v, Part) else v, self._args)
        with np.errstate(all="ignore"):
            result = self._function(*args, **dict(zip(self._names, values, strict=True)))
        pairs = ((a, b) for a in arrays_in(result) for b in arrays_in([args, values]))
        if at_first and any(np.may_share_memory(*pair) for pair in pairs):
            refuse(f"a view that {self.name} gives")
        return result

    def compute(self, numbers, out):
        """Call the library with `numbers`, and store the results in `out`."""
        values: list = []
        nested(values.append, self._result(numbers))
        nested(lambda part: part.write(values.pop(0), out), self.result)
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


def apart(function, args, kwargs) -> Any:
    """``function(*args, **kwargs)`` as an island, with symbols in place of numbers.

    The library function must have no side effects, and its value depends on its arguments only.
    """
    name, g = getattr(function, "__name__", ""), graph_of(args, list(kwargs.values()))
    if g is None or g.start is None:
        refuse(f"it calls {name}")
    changes = [k for k, v in kwargs.items() if v is not None and v is not False]
    if any(k in ("out", "output") or k.startswith("overwrite") for k in changes):
        refuse(f"{name} that writes to what it is given")
    if g.in_handler():
        refuse(f"{name} where what it raises is caught")
    given = Given((tuple(args), tuple(kwargs.values())))
    if not 0 < given.size <= MOST_NUMBERS or len(g.islands) >= MOST_ISLANDS:
        refuse(f"{name} of {given.size} numbers, or in too many ways", final=True)
    try:
        key = pickle.dumps((function, given.args, tuple(kwargs), given.size))
    except Exception:
        refuse(f"it calls {name}, which no other process could find")
    nodes = [symbol(g, v).node for each in given.numbers for v in each] if not g.batches else []
    if key not in g.kept:  # all paths share the island
        g.kept[key] = Island(key, name, _at_the_start(g, nodes) if nodes else None)
    island = g.kept[key]
    (slot,) = g.reads.parameters(g.reads.step(g.reads.root(0), "island", island), island.address)
    g.islands[slot] = island
    data = slot, island.n_in, island.n_out
    if g.batches:
        found = BATCHES["island"](g.batches, given.numbers, data)
    else:
        whole = g.make("island", nodes, data)
        entries = [g.make("entry", (whole,), i) for i in range(island.n_out + 1)]
        found = Array.of([Symbol(g, entry, NUMPY) for entry in entries])
    g.raises_if(g.negation(g.compare(found[-1].node, g.const(0.0), "eq")), lambda: None)
    return nested(lambda part: part.of(found), island.result)


def _at_the_start(g, nodes):
    """The values of nodes at the start."""
    t, y = g.start
    size = 1 + max((node.data for node in g.nodes if node.op == "y"), default=0)
    y = np.resize(np.asarray(y, float), (size, 1))
    return evaluate(g, nodes, np.array([t], float), y, g.values)[0][:, 0]


def or_apart(function, written_out):
    """Try `written_out`, a formula for a library function; if it refuses, call the library."""

    def call(*args, **kwargs):
        g, before = graph_of(args, list(kwargs.values())), LATEST.refusal
        raising = g and g.raising
        try:
            return written_out(*args, **kwargs)
        except OutOfTime:
            raise
        except (Refusal, TypeError, AttributeError):  # C code raises TypeError on symbols
            if g is None or g.start is None:
                raise
        LATEST.refusal, g.raising = before, raising
        return apart(function, args, kwargs)

    return call


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
