"""The tracer: runs a user's function on symbols and records the graph of its operations.

The folders:

- operations: one record each, with value, domain and derivative.
- graph: nodes, which are numbers, and rows, which are arrays of numbers with ids.
- symbols: the objects that replace numbers and arrays.
- functions: functions of Python, NumPy and SciPy on symbols.
- outside: copies of the function's surroundings.
- reads: the values from outside that must still hold at a later call.
- paths: one run of the function for each path through its branches.
- switching: the times and the states at which a function switches.
- emit: machine code.
"""
