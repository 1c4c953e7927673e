"""Vectors of numbers as a number type, and their elementary functions."""
