"""Many trajectories: plans, workers, blocks, reductions, and what comes out of them."""
