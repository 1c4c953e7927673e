"""What the key of an entry covers."""
