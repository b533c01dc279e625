"""Streams on one clock."""
