"""The options of all solvers: one table, and what follows from its records."""
