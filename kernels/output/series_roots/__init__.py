"""The roots of event functions along a step: by signs, by polynomials."""
