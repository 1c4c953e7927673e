"""Gauss, Gauss-Nystrom and energy-conserving methods of fixed step."""
