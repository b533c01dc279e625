"""Where recordings and simulation differ: one locator a file."""
