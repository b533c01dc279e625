"""E, nu and mu of the gel from measured wrenches, and whether they can be known."""
