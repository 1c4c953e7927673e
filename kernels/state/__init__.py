"""The records and rows that a solve consists of."""
