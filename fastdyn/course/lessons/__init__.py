"""One lesson a system: the numbers of the course beside the exact ones."""
