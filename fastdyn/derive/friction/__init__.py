"""Friction that changes between slip and rest: contacts, their modes, solves through them."""
