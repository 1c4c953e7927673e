"""Timing while groups run; tables and figures of what they found."""
