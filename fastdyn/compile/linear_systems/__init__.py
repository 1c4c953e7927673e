"""Routines that solve one small system of equations, or one narrow band, in straight-line code."""
