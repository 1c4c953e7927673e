"""Machine code: kept on disk by content, loaded into a name space of its own, called from Python.

An entry is one object file with one visible symbol, named by the hash of everything that the code
depends on.  All other symbols are internal, and each file is linked into a name space of its own:
the code of two processes cannot be mixed up, whatever names Numba gave the parts.
"""

from .announced import meant_for
from .cache import COUNTS, Code, assembled, compiled, first_kept, linked, stored, without_function
from .call import Call
from .key.sources import FUNCTIONS, KERNELS, sources
from .object_file import OFFERED, Unsealable

__all__ = [
    "COUNTS",
    "FUNCTIONS",
    "KERNELS",
    "OFFERED",
    "Call",
    "Code",
    "Unsealable",
    "assembled",
    "compiled",
    "first_kept",
    "linked",
    "meant_for",
    "sources",
    "stored",
    "without_function",
]
