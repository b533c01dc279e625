"""Where things lie in a store, and how its files are written safely."""
