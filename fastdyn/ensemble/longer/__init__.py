"""Ensembles whose states are longer than the function's: discrete states, sensitivities."""
