"""Single nodes of one formula as batches."""
