"""Compiles how the equations and events of a traced function change sensitivities."""
