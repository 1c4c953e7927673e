"""Functions drawn at random to deceive the compiler, and what SciPy makes of them."""
