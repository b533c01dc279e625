"""Metrics over stores: how far apart the pictures of sensors are."""
