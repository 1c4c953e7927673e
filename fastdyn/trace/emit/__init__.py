"""Emits a graph as machine code, in LLVM's textual form."""
