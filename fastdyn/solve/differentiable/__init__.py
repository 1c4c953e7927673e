"""A solve as a function of arrays, with its derivatives, for other libraries: JAX, torch, PyTensor.

- given: what varies and what does not, of the arguments of a call.
- call: one call: its outputs, and their derivatives in both directions.
- outputs: the outputs of a solve in shapes that are known before it.
- door: the public function of a library.
- members: calls of many members at once.
"""

from .call import Call
from .door import door
from .given import Library, call_of
from .members import Axis, pulled, pushed, sloped, solved
from .outputs import Solution

__all__ = [
    "Axis", "Call", "Library", "Solution", "call_of", "door", "pulled", "pushed", "sloped",
    "solved",
]  # fmt: skip
