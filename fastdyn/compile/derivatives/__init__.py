"""Functions derived from a traced one: Jacobians, sensitivities, switches, forms on vectors."""
