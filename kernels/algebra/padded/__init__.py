"""Matrices of some ten to sixty rows, enlarged to whole vectors."""
