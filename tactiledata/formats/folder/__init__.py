"""The folder log."""
