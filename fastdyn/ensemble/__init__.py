"""Many trajectories: plans, workers, blocks, reductions, results."""

from fastdyn.problem.members import Shared

from .reductions import Fold
from .trajectories import Trajectories

__all__ = ["Fold", "Shared", "Trajectories"]
