"""The compiled entry: a solve like the last ones, from the call to the result, as a C function.

`docs/entry.md` explains the whole.  Files: `objects`, where Python's objects keep what C reads;
`emit`, reads, calls and loops as LLVM; `given`, `follow`, `solve`, `result`, the C functions;
`rows` and `words`, what they take; `kept`, runs that C and Python take in turns; `load`, the
machine code in this process; `solver`, the entry of `prepare`; `again`, that of `solve_ivp`.
"""
