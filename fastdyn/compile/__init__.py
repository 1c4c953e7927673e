"""The user's functions -> machine code of one known form; their values -> parameters."""
