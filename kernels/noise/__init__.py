"""Steps of stochastic differential equations on many paths at once."""
