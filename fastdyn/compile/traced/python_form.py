"""The base of traces in a mode: compiles the pointer form, and calls its code from Python."""

import functools
import math
from typing import Any

import numpy as np

from fastdyn import code_store
from fastdyn.trace.islands.island import raise_interrupts

from ..callables.compiled import Function
from ..function_convention import call, code_at
from ..parameters import n_words


class PythonForm:
    """The base of traces whose pointer form stores `n_stored` numbers."""

    n_stored: int
    trace: Any
    mode: Any
    kinds: list
    key: Any
    text: Any
    dispatcher: Any
    series: Any

    def compiled(self, seconds=math.inf):
        """The compiled Function, from disk or made now."""
        key = self.key()
        code = code_store.assembled(key, self.text)
        return Function(
            key, code.address, sum(map(n_words, self.kinds)),
            self.dispatcher and functools.cache(self.dispatcher), code, self.mode, seconds,
            self.series and code_store.first_kept(self.series), self,
        )  # fmt: skip

    def python(self, address, block) -> Any:
        """``function(t, y)`` that calls the machine code; it returns None if the code raises."""
        code = code_at(address)

        def function(t, y):
            out = np.empty(self.n_stored)
            raised = call(code, t, np.ascontiguousarray(y, dtype=float), block, out)
            if raised:
                raise_interrupts(self.trace.graph.islands.values())
            return None if raised else out

        return function
