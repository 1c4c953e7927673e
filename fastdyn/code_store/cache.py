"""Object files on disk, named by everything that the code in them depends on.

Numba's own cache is keyed by file and function name and does not notice an edit in another file.
Here the name of a file is the hash of its key, so an entry is never out of date: the entry is
either right or absent.  Entries are written whole and renamed, and verified when read.  New code is
loaded from its sealed bytes, as an entry is.

Compilers are imported when there is code to make: kept code is loaded without Numba.
"""

import contextlib
import functools
import hashlib
import os
import threading
from typing import Any, NamedTuple

from . import precompiled
from .announced import announced
from .call import laid_out
from .folders import folders
from .key.environment import environment
from .key.sources import FUNCTIONS
from .object_file import NotWhole, packed, unpacked
from .one_at_a_time import alone
from .quiet import warnings

COUNTS = {"loaded": 0, "compiled": 0, "stored": 0}
_assembling = threading.Lock()
_compiling = threading.RLock()


class Code(NamedTuple):
    """Machine code: its address, and the layout of a kernel's arguments, for `Call`.

    The code is in the process as long as its `library` is held.
    """

    address: int
    layout: dict
    library: Any


def first_kept(make):
    """A cache of code for a process: the first value for given arguments stays, in all threads.

    functools.cache replaces the value that one thread has got by the value of a slower thread.  The
    replaced code would then leave memory, while its address is in a block or an array.
    """
    values = {}

    @functools.wraps(make)
    def found(*given):
        value = values.get(given)
        return values.setdefault(given, make(*given)) if value is None else value

    return found


def compiled(key, build, made_by=FUNCTIONS):
    """The machine code for `key`, from disk or by `build()`.

    Parameters
    ----------
    key : str or None
        Everything, besides `environment`, that the code depends on.  None: never on disk.
    build : callable
        Returns a Numba dispatcher and the signature to compile it for.
    made_by : key.sources.MadeBy
        The sources that change the code: `KERNELS` around the modules of a kernel for code that
        contains no function of the user, and whose `build` is in the folders of `KERNELS`.

    Raises
    ------
    Unsealable
        With the reason; exceptions of Numba pass through.
    """
    found = key and stored(key, made_by)
    if found:
        return found
    symbol = _symbol(key, made_by)
    if key is None:
        return _compiled(None, symbol, build)
    with announced(made_by.is_kernel), _compiling, alone(_file(symbol)):  # or another process
        return stored(key, made_by) or _compiled(key, symbol, build)


def _compiled(key, symbol, build):
    """The machine code of the dispatcher that `build` returns."""
    with _numba() as emit_object:
        dispatcher, signature = build()
        code, needs, arguments = emit_object.of(dispatcher, signature, symbol)
    return _kept(key, symbol, code, needs, arguments)


@contextlib.contextmanager
def _numba():
    """Numba in its calm state, and the module that takes code from Numba."""
    import numba  # noqa: F401  # waits for an import in another thread; a submodule's does not
    from numba.core.errors import NumbaWarning

    from . import emit_object
    from .deferred import deferred

    with deferred(), warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaWarning)  # about code that is not the caller's
        yield emit_object


def assembled(key, write, scheduled=False):
    """The machine code for `key`, from disk, or from the LLVM text that `write(symbol)` returns.

    `key` is everything that the code depends on, as in `compiled`.  `scheduled` text has its
    instructions in their final order: the optimiser would only worsen the order.
    """
    found = stored(key)
    if found:
        return found
    from .target import translated

    symbol = _symbol(key)
    with _assembling:
        code, needs = translated(write(symbol), symbol, scheduled)
    return _kept(key, symbol, code, needs, [])


def without_function(key, build=None, made_by=FUNCTIONS):
    """The kernel for `key` without the function that the kernel calls, from disk or by `build()`.

    Returns None if the kernel is not on disk and `build` is None; for `build` and `made_by` see
    `compiled`.
    """
    symbol = _symbol(key, made_by)
    found = _bitcode(symbol)
    if found or build is None:
        return found
    with announced(made_by.is_kernel), _compiling, alone(_file(symbol)):
        found = _bitcode(symbol)
        if found:
            return found
        with _numba() as emit_object:
            made = emit_object.without_function(*build())
        COUNTS["compiled"] += 1
        header = _header(key, symbol, [], made.arguments)
        COUNTS["stored"] += folders.store(_file(symbol), packed(header, made.bitcode))
        return made


def _bitcode(symbol):
    from .unlinked import Unlinked

    for data in folders.entries(_file(symbol)):
        try:
            header, bitcode = unpacked(data, symbol, lambda *_: None)
        except NotWhole:
            continue
        COUNTS["loaded"] += 1
        return Unlinked(bitcode, header["arguments"])
    return None


def linked(key, kernel, functions, look, made_by=FUNCTIONS):
    """The machine code for `key`: a kernel of `without_function` and the functions that it calls.

    `functions` maps each name to ``write(name)``, as in `assembled`.  ``look()`` is called now and
    then, and may raise.
    """
    from .unlinked import linked

    symbol = _symbol(key, made_by)
    texts = {name: write(name) for name, write in functions.items()}
    look()
    code, needs = linked(kernel, texts, symbol, look)
    return _kept(key, symbol, code, needs, kernel.arguments)


def _kept(key, symbol, code, needs, arguments):
    """Keep new code on disk, and load the code into this process."""
    COUNTS["compiled"] += 1
    header = _header(key, symbol, needs, arguments)
    if key is not None:
        COUNTS["stored"] += folders.store(_file(symbol), packed(header, code))
    return _loaded(header, code)


def _header(key, symbol, needs, arguments):
    return {
        "symbol": symbol,
        "needs": needs,
        "arguments": arguments,
        "key": hashlib.sha256((key or "").encode()).hexdigest(),
    }


def stored(key, made_by=FUNCTIONS):
    """The machine code for `key` from disk; None without an entry."""
    came = precompiled.entry(key, made_by) if made_by.is_kernel else None
    if came and (found := _verified(*came)):
        return found
    symbol = _symbol(key, made_by)
    for data in folders.entries(_file(symbol)):
        found = _verified(data, symbol)
        if found:
            return found
    return None


def _verified(data, symbol):
    """The code of an entry; None if the entry is damaged or cannot be loaded here."""
    from .loader import UnknownSymbol

    try:
        found = _loaded(*unpacked(data, symbol))
    except (NotWhole, UnknownSymbol):
        return None
    COUNTS["loaded"] += 1
    return found


def _symbol(key, made_by=FUNCTIONS):
    if key is None:
        return f"fastdyn_{os.urandom(32).hex()}"
    return f"fastdyn_{hashlib.sha256((environment(made_by) + key).encode()).hexdigest()}"


def _file(symbol):
    return f"{symbol.removeprefix('fastdyn_')}.o"


def _loaded(header, code):
    from .loader import load

    library = load(code, header["symbol"], header["needs"])
    return Code(library.address, laid_out(header["arguments"]), library)
