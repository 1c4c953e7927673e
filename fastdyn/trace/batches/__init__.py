"""Long arrays that depend on the state: each operation is a batch of consecutive node numbers."""
