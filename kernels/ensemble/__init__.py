"""Several trajectories in the lanes of vectors, and the scheduler that assigns the lanes."""
