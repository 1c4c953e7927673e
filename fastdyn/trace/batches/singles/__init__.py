"""Turns single nodes with a common formula into batches."""
