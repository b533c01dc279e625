"""Trajectories, images and signals in a Zarr store that may be killed at any moment (docs/store.md)."""
