"""Functions of generated Python source."""

import itertools
import linecache
import weakref
from typing import Any

_serial = itertools.count(1)


def function_of(text, name, what, scope) -> Any:
    """The function `name` of a text, with `scope` as its globals; `what` describes the text.

    Tracebacks show the lines of the text for as long as the function lives.
    """
    place = f"<{what} {next(_serial)}: {name}>"
    exec(compile(text, place, "exec"), scope)
    function = scope.pop(name)
    linecache.cache[place] = len(text), None, text.splitlines(True), place
    weakref.finalize(function, linecache.cache.pop, place, None)
    return function
