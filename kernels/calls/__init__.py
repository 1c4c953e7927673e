"""How kernels call functions of the user, and each other."""
