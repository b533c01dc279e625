"""The MCAP format."""
