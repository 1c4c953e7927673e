"""What the equations and events of a traced function do to its sensitivities."""
