"""Taylor coefficients from recurrences: of one trajectory, of a large system, of lanes."""
