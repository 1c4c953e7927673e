"""Benchmarks: ``python -m bench`` measures fastdyn beside what a user would pick instead."""
