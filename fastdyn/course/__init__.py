"""The course replayed: lessons, tour and gallery."""
