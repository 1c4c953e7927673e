"""The kinds of numbers: NumPy's, with inf and nan, and Python's float and int, which raise."""

NUMPY, FLOAT, INT = 2, 1, 0
