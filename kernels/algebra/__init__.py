"""Small linear systems, and constrained motion."""
