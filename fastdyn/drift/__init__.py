"""Long runs: how energy and other invariants drift, by method, and at what price."""
