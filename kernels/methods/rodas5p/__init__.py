"""Rodas5P, a Rosenbrock method of order 5(4)."""
