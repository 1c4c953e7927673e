"""Derivatives of solutions of F(t, y, y') = 0: the equations differentiated along the solution."""
