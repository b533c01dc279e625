"""Trajectories, images and signals in a Zarr store that may be killed at any moment (docs/store.md).

Read the rooms in this order:

- ``layout``: where things lie in a store, and how single files are written so that a kill leaves the old or the new.
- ``read``: a store to read; `read.reader.Store` is what all other packages use.
- ``write``: a recording becomes a staged take, and staged takes become part of a store in one commit.
- ``change``: stores merged, recordings replaced, sensors added; each is a commit of ``write``.
- ``check``: whether a store is whole, and what of it can be mended without inventing data.

A room imports only rooms above it in this list. Nothing here interprets numbers: forces and clocks belong to
``ingest``.
"""
