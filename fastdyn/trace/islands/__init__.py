"""Calls of library functions that have no formula in the graph.

Such a call is an island of Python in compiled code.  Nodes of the graph compute the numbers that go
into the call, and use the numbers that the call returns.  The compiled code calls the library once
for each evaluation.
"""
