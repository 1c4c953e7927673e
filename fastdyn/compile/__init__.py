"""Turns the user's functions into machine code of one form, and their values into parameters."""
