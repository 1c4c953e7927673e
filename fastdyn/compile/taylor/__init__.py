"""The Taylor method: a trace as recurrences for Taylor coefficients, and those as machine code."""
