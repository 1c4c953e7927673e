"""States of rest: their search, their linearisation, their kinds."""
