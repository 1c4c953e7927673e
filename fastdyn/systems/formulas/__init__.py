"""Closed-form solutions and inputs that several systems share."""
