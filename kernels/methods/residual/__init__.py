"""BDF of orders 1 to 5 for F(t, y, y') = 0."""
