"""Random numbers from counters: the same numbers in any lane, block, thread and order."""
