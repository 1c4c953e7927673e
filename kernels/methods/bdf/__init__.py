"""BDF of orders 1 to 5, with SciPy's steps."""
