"""Checks of a model before a run: the model determines its motion, and hides no trap."""
