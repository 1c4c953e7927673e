"""Copies of everything that a traced function refers to, so that a run changes only the copies."""
