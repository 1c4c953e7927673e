"""One solve from its first step to its result: the loop over chunks, output, checkpoints."""
