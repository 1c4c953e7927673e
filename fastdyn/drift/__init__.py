"""Long runs: the drift of energy and other invariants, and its cost, by method."""

from .compare import compare_drift
from .study import Drift, Study

__all__ = ["Drift", "Study", "compare_drift"]
