"""Long complex arrays: a real and an imaginary one, each of node numbers."""
