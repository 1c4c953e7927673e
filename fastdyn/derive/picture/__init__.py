"""Derived systems as pictures: what a model says of its bodies, drawn."""
