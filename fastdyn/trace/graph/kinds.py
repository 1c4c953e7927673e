"""The rules that a number follows: Python's, or NumPy's (inf and nan where Python raises)."""

NUMPY, FLOAT, INT = 2, 1, 0
