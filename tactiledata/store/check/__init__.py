"""Whether a store is whole, and what of it can be mended."""
