"""A simulator with effects, and the settings that it is given."""
