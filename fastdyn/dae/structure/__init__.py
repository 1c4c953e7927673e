"""Index reduction: F(t, y, y') = 0 of any index becomes ordinary differential equations."""
