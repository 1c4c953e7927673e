"""Benchmarks: ``python -m bench`` measures fastdyn beside SciPy and hand-written C++."""
