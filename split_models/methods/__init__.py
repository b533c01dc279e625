"""The rows of the tables: SPLIT and its baselines."""
