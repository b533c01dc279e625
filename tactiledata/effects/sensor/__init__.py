"""Effects of the force sensor and of what hangs on it."""
