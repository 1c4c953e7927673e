"""Calls of library functions that have no formula in the graph.

The graph computes the inputs of such a call number by number, and uses the results number by
number.  The compiled code calls the library itself, once for each evaluation: an island of Python.
"""
