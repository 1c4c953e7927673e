"""Emits a graph as source text, in C or in JavaScript."""
