"""Trajectories, images and signals in a Zarr store that may be killed at any moment (docs/store.md).

Read the rooms in this order:

- ``layout``: where things lie in a store, and how single files are written so that a kill leaves the old or the
  new.
- ``read``: a store to read; `read.reader.Store` is what all other packages use.
- ``write``: a recording becomes a staged take, and staged takes become part of a store in one commit.
- ``check``: whether a store is whole, and what of it can be mended without inventing data.
- ``change``: stores merged, recordings replaced, sensors added; each is a commit of ``write``.

A room imports only rooms above it in this list. Nothing here interprets numbers: forces and clocks belong to
``ingest``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

__all__ = ["Store"]


def __getattr__(name: str) -> Any:
    """Import `Store` when it is asked for: the rooms of this package load without it."""
    if name == "Store":
        from tactiledata.store.read.reader import Store

        return Store
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
