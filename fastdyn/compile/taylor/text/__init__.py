"""Writes LLVM's text: instructions, loops, the frame of a kernel."""
