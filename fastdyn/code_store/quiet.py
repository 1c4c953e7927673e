"""Numba in a thread behind the others, which are not to notice.

`warnings.catch_warnings` changes the filters of all threads, and two threads that enter and leave
in turn lose those of the user.  In the thread behind, Numba's modules get this one instead of
`warnings`: it catches nothing and says nothing there, and is `warnings` in all other threads.
"""

import contextlib
import sys
import threading
import types
import warnings as real

_here = threading.local()


class _Warnings(types.ModuleType):
    def __getattr__(self, name):
        return (_silent if _behind() else real).__dict__[name]


def _behind():
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
    """From now on this thread is behind the others."""
    _here.behind = True
    for name, module in list(sys.modules.items()):
        if name.startswith("numba.") and getattr(module, "warnings", None) is real:
            module.warnings = warnings  # pyright: ignore[reportAttributeAccessIssue]
