"""Calls the machine code of a trace from Python."""

from typing import Any

import numpy as np

from fastdyn.trace.islands.island import raise_interrupts

from ..function_convention import call, code_at


class PythonForm:
    """The base of traces whose pointer form stores `n_stored` numbers."""

    n_stored: int
    trace: Any

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
