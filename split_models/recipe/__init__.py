"""A recipe, its data and its models."""
