"""The loops over steps, and the choice of the step size."""
