"""
Equations of motion from what stands on the blackboard.

    from fastdyn.derive import Model, i, j, rate

A `Model` collects coordinates, bodies, forces and constraints; ``model.newton()`` and
``model.lagrange()`` derive the equations of motion, ``.explain()`` shows how, ``.system`` is the
`fastdyn.systems.System`.
"""

try:
    import sympy as _sympy  # noqa: F401
except ImportError:
    raise ImportError(
        'fastdyn.derive needs SymPy: python -m pip install "fastdyn[derive]" installs it.'
    ) from None

from .bodies import Body
from .derivation import Derivation
from .model import Model
from .notation import Rotation, cross, dot, i, j, k, length, rate, rotation, t

__all__ = [
    "Body", "Derivation", "Model", "Rotation", "cross", "dot", "i", "j", "k", "length", "rate",
    "rotation", "t",
]  # fmt: skip
