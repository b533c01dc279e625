"""A store to read."""
