"""The option `adjoint`: a solve that keeps its steps, and the sweep back over them."""
