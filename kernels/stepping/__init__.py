"""The loops over steps, and the choice of their size."""
