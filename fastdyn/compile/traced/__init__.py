"""Machine code from a trace: found or made, compared with the function, kept."""
