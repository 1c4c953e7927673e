"""WisdomHolman: the orbits around a dominant mass, exactly, and kicks by what perturbs them."""
