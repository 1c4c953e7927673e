"""What a step leaves behind: interpolants, events, extrema, invariants."""
