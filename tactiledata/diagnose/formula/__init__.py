"""A formula for what no known effect explains."""
