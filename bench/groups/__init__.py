"""What ``python -m bench --only NAME`` runs: ``rows(quick)`` of each module."""
