"""The tracer: runs a user's function on symbols and records the graph of its operations.

The folders:

- graph: the expressions.
- reads: the values from outside that must still hold at a later call.
- symbols: the objects that replace numbers.
- numpy, scipy: library functions on symbols.
- outside: copies of the function's surroundings.
- paths: one run of the function for each path through its branches.
- batches: long arrays.
- islands: calls of library functions that have no formula.
- emit: machine code.
"""
