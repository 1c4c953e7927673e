"""Taylor: the loop over steps around the series of a function.

`fastdyn/compile/taylor` writes the code that computes a series; the code describes itself by words.
"""
