"""Exercises that are handed in: equations that a student writes, compared with a reference."""
