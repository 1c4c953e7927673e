"""Constants that a function compares by `is`; symbols and Numba's values have no identity."""

import dis
import functools
import types
from typing import Any

CONSTANTS = (None, True, False, Ellipsis)


@functools.lru_cache(1024)
def compared_by_identity(code):
    """The constants on the right of `is` in code.

    For another right operand, the result has the code itself and the True and False in the code.
    """
    before: Any = None
    found = []
    for i in dis.get_instructions(code):
        if i.opname == "IS_OP":
            right = [c for c in CONSTANTS if before.opname == "LOAD_CONST" and before.argval is c]
            found += right or [code, *[c for c in code.co_consts if isinstance(c, bool)]]
        before = i
    for inner in [c for c in code.co_consts if isinstance(c, types.CodeType)]:
        within = compared_by_identity(inner)
        found += [code if each is inner else each for each in within]
    return found
