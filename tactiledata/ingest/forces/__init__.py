"""Contact forces from raw readings."""
