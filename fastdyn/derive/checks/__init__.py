"""What is looked at in a model before a run: whether it determines the motion, and traps."""
