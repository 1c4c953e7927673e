"""The functions of Python, NumPy and SciPy on symbols: a stand-in each, or a row of a table."""
