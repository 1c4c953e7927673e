"""Switching times: where a function of the time and of parameters changes, from its graph."""
