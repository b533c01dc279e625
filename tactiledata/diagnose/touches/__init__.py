"""Measured touches, and the simulation that plays them."""
