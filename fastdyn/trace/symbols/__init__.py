"""The numbers and arrays of a traced function: one class, by Python's and NumPy's protocols."""
