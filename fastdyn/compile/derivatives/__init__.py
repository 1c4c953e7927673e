"""What is derived from a traced function: Jacobians, sensitivities, switches, forms on vectors."""
