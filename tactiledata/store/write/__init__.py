"""Recordings into a store, safe to kill at any moment."""
