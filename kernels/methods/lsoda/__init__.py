"""LSODA: Adams' formulas and BDF, with SciPy's steps."""
