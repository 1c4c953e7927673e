"""The public solvers of one trajectory."""
