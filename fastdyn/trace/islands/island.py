"""A library function that compiled code calls, with numbers as inputs and outputs.

The function's address is a parameter of the code.  The last output is the failure flag: 1 if the
library raised, or returned an object of another form than in its first call; else 0.
"""

import contextlib
import ctypes
from typing import Any

import numpy as np

SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
DOUBLES = ctypes.POINTER(ctypes.c_double)
MAX_KNOWN = 1000  # most pairs of addresses (inputs, outputs) with a kept work function


class Address(float):
    """An address as a float, which is exact; the attribute `of` keeps the object there alive."""

    of: Any


class Island:
    """A library function in compiled code.

    Parameters
    ----------
    function : callable
    given : forms.Given
    result : forms.Result
    name : str
        The name of the function in messages.
    place : tuple or None
        File and line of the first call in the user's code.

    Attributes
    ----------
    address : Address
    exception : BaseException or None
        An interrupt that stopped the function, for the caller of the compiled code to raise.
    inside, pending, later, account
        As in the `Callback` of `compile`, because a solve treats Islands and Callbacks alike.
    """

    account: Any = None

    def __init__(self, function, given, result, name="", place=None):
        self._function, self._given, self._result = function, given, result
        self.name, self.place = name, place
        self.n_in, self.n_out, self._known = given.size, result.size, {}
        self.exception: Any = None
        self.inside, self.pending, self.later = False, None, float
        self._called = SIGNATURE(self._call)
        self.address = Address(ctypes.cast(self._called, ctypes.c_void_p).value or 0)
        self.address.of = self

    def values(self, args):
        """The outputs for numbers or arrays: one row for each output, the failure flag last."""
        points = np.broadcast_arrays(*[np.asarray(a, float) for a in args])
        found = np.ones((points[0].size, self.n_out + 1))
        for k in range(points[0].size):
            with contextlib.suppress(Exception):
                self._work(np.array([p.flat[k] for p in points]), found[k])()
        return found.T.reshape(self.n_out + 1, *points[0].shape)

    def _work(self, numbers, out):
        """A function that calls the library with `numbers`, and stores the results in `out`."""
        function, of, store = self._function, self._given.of, self._result.store
        fixed = self._given.fixed and of(numbers)

        def work():
            args, named = fixed or of(numbers)
            with np.errstate(all="ignore"):
                result = function(*args, **named)
            store(result, out)
            out[-1] = 0.0

        return work

    def _new_work(self, numbers, out):
        if len(self._known) > MAX_KNOWN:
            self._known.clear()
        memory = [
            np.ctypeslib.as_array(ctypes.cast(address, DOUBLES), (n,))
            for address, n in ((numbers, max(self.n_in, 1)), (out, self.n_out + 1))
        ]
        work = self._known[numbers, out] = self._work(*memory)
        return work

    def _call(self, numbers, out):
        try:  # the compiled code has set the failure flag already
            self.inside = True
            if self.pending is not None:
                interrupt, self.pending = self.pending, None
                interrupt()
            (self._known.get((numbers, out)) or self._new_work(numbers, out))()
        except Exception:
            pass
        except BaseException as error:
            self.exception = error
        self.inside = False


def raise_interrupts(islands):
    """Raise the interrupt that stopped one of the islands, if any."""
    islands = [each for each in islands if isinstance(each, Island)]
    found = [each.exception for each in islands if each.exception is not None]
    if found:
        for each in islands:
            each.exception = each.pending = None
        raise found[0]


def calls_libraries(graph):
    """The Islands of a graph."""
    return [each for each in graph.islands.values() if isinstance(each, Island)]


def islands_of(bounds):
    """The islands that bound functions call, found among the values of their parameters."""
    found = [getattr(value, "of", None) for bound in bounds for _, value in bound.values]
    return [each for each in found if isinstance(each, Island)]
