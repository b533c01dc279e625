"""The networks of the SPLIT paper."""
