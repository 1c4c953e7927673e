"""Elimination of sparse matrices in an order that their pattern fixes."""
