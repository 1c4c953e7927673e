"""Several trajectories in the lanes of vectors, and who is in which lane."""
