"""The memory of a process for functions: one bounded store with one lock.

Code that uses an entry refers to the entry's value: a run refers to its functions, a function to
its machine code.  Above the bound, the store releases the entries that were unused for longest, of
any kind.  A released value that is in use survives; a released value that is needed later is made
again.
"""

import functools
import os
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any

MOST = int(os.environ.get("FASTDYN_MEMORY", "4096"))  # the limit of the entries' total size


class _Entry:
    """A value of a table, and its size."""

    __slots__ = ("key", "size", "table", "value")

    def __init__(self, table, key, value, size):
        self.table = table
        self.key = key
        self.value = value
        self.size = size


class _Store:
    """All entries, the entry that was unused for longest first, and their total size."""

    def __init__(self):
        self.entries: OrderedDict[_Entry, None] = OrderedDict()
        self.lock = threading.RLock()
        self.size = 0
        self.latest: Any = None  # the entry used last, which stands at the end

    def release(self, most=0):
        """Remove and return entries until at most one, or the size `most`, remains."""
        gone = []
        self.latest = None
        while self.size > most and len(self.entries) > (most > 0):
            gone.append(self.entries.popitem(last=False)[0])
            del gone[-1].table.entries[gone[-1].key]
            self.size -= gone[-1].size
        return gone


_store = _Store()
_clear: list[Callable] = []  # called by `forget`


class Table:
    """A table of entries of one kind; the store may release any of them.

    The size of an entry is in units of about 50 kB.
    """

    def __init__(self):
        self.entries: dict[Any, _Entry] = {}

    def get(self, key) -> Any:
        """The value of a key, which is now used; None if there is none.  Takes no lock: 0.1 us."""
        found = self.entries.get(key)
        if found is None:
            return None
        if found is not _store.latest:
            try:
                _store.entries.move_to_end(found)
                _store.latest = found
            except KeyError:  # another thread has just released it
                pass
        return found.value

    def put(self, key, value, size=1):
        """Store a value, release entries above the bound, and return the value."""
        with _store.lock:
            before = self.entries.get(key)
            if before is not None:
                del _store.entries[before]
                _store.size -= before.size
            entry = self.entries[key] = _Entry(self, key, value, size)
            _store.entries[entry] = None
            _store.size += size
            gone = _store.release(MOST)  # forgets which entry stood at the end
        del before, gone  # the released values are destroyed here, without the lock
        return value


def cached(function):
    """functools.lru_cache for a function with small results; `forget` clears it."""
    remembering = functools.lru_cache(MOST)(function)
    _clear.append(remembering.cache_clear)
    return remembering


def forget():
    """Release everything that the process remembers: functions, facts about functions, code.

    Existing solvers (`prepare`, `Stepper`) and solves in other threads keep what they use.  The
    next solve of a function reads its code from disk.
    """
    with _store.lock:
        gone = _store.release()
    del gone
    for clear in _clear:
        clear()
    if "fastdyn.code_store.loader" in sys.modules:
        sys.modules["fastdyn.code_store.loader"].unload()


def remembered():
    """The number of entries, and their total size."""
    with _store.lock:
        return len(_store.entries), _store.size


def _in_child():
    _store.lock = threading.RLock()  # a thread of the parent may have held the lock


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)
