"""What a system is, how it is declared, and how it is solved."""
