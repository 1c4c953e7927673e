"""The compiled entry: a C function that repeats a solve, from the call to the result.

`docs/entry.md` explains the entry.  The files are:

- `objects`: the layout of Python's objects, from which C reads;
- `emit`: reads, calls and loops as LLVM;
- `given`, `follow`, `solve`, `result`: the C functions;
- `rows` and `words`: the arguments of the C functions;
- `kept`: runs that C and Python use alternately;
- `load`: the machine code in this process;
- `solver`: the entry of `prepare`; `again`: the entry of `solve_ivp`.
"""
