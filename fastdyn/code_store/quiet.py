"""Numba in a background thread, without effect on the warnings of other threads.

`warnings.catch_warnings` changes the filters of all threads, and two threads that enter and leave
in turn lose the filters of the user.  Numba's modules therefore get this module instead of
`warnings`: in the background thread this module catches and reports nothing, in all other threads
this module acts as `warnings`.
"""

import contextlib
import sys
import threading
import types
import warnings as real

_here = threading.local()


class _Warnings(types.ModuleType):
    def __getattr__(self, name):
        return (_silent if is_behind() else real).__dict__[name]


def is_behind():
    """Whether this thread is the background thread."""
    return getattr(_here, "behind", False)


@contextlib.contextmanager
def _caught(*_, **__):
    yield []


def _nothing(*_, **__):
    pass


_silent = types.SimpleNamespace(
    **{
        **real.__dict__,
        "catch_warnings": _caught,
        **dict.fromkeys(("warn", "warn_explicit", "simplefilter", "filterwarnings"), _nothing),
    }
)
warnings = _Warnings("warnings")


def behind():
    """Mark this thread as the background thread."""
    _here.behind = True
    for name, module in sys.modules.copy().items():  # other threads import meanwhile
        if name.startswith("numba.") and getattr(module, "warnings", None) is real:
            module.warnings = warnings  # pyright: ignore[reportAttributeAccessIssue]
