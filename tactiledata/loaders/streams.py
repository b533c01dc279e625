"""What the names of streams stand for: images, values at the moments of frames, native-rate signals, references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import StoreError, UnknownName, UsageError

if TYPE_CHECKING:
    from tactiledata.store.reader import Store

BACKGROUND = "background"
MESH = "mesh"
RESERVED = ("sensor", "indenter", "trajectory", "frame", "t_ns", "in_split")
"""Keys that every item has; no stream may be called so."""

Kind = Literal["image", "background", "aligned", "signal", "frame_value"]
Unit = Literal["frame", "trajectory"]


@dataclass(frozen=True)
class Stream:
    """One stream of a dataset.

    Parameters
    ----------
    name : str
    kind : "image", "background", "aligned", "signal" or "frame_value"
        ``aligned``: a value at the moment of each frame; ``signal``: samples at their native rate.
    columns, units : (k,) names
        Empty for pictures.
    """

    name: str
    kind: Kind
    columns: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def is_picture(self) -> bool:
        """Whether it gives images."""
        return self.kind in ("image", "background")


def values_at_frames(store: Store, stream: Stream, rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Values (n, k) of an ``aligned`` or ``frame_value`` stream at rows of frames; NaN where none was recorded."""
    if stream.kind == "frame_value":
        return store.frame_values(stream.name, rows)
    return store.aligned(stream.name, rows)[0]


def find_streams(store: Store, names: Sequence[str] | str, unit: Unit) -> tuple[Stream, ...]:
    """Streams by name.

    Raises
    ------
    UnknownName
        A name that the store does not hold; the message lists what it holds.
    UsageError
        No name, a name given twice, or several cameras.
    StoreError
        Meshes, where none are attached.
    """
    asked = (names,) if isinstance(names, str) else tuple(names or ())
    if unit not in ("frame", "trajectory"):
        raise UnknownName("unit of a dataset", str(unit), ("frame", "trajectory"))
    if not asked or len(set(asked)) < len(asked) or not all(isinstance(name, str) for name in asked):
        raise UsageError(
            f"streams are {asked!r}",
            "names of streams, at least one, each once",
            f"The store holds: {', '.join(known(store))}.",
        )
    streams = tuple(_find(store, name, unit) for name in asked)
    cameras = [stream.name for stream in streams if stream.kind == "image"]
    if len(cameras) > 1:
        raise UsageError(
            f"streams name {len(cameras)} cameras ({', '.join(cameras)})",
            "at most one: each frame of a store is one image of one camera",
            "Make a dataset for each camera; `frame` and `t_ns` of the items tell which belong together.",
        )
    return streams


def known(store: Store) -> list[str]:
    """Names of all streams of a store."""
    manifest = store.manifest
    background = [BACKGROUND] if manifest["references"] else []
    values = [name for family in ("aligned", "signals", "frame_values") for name in manifest[family]]
    return [*manifest["cameras"], *dict.fromkeys(values), *background]


def _find(store: Store, name: str, unit: Unit) -> Stream:
    manifest = store.manifest
    if name in RESERVED:
        raise UsageError(f"a stream is called {name!r}", "another name", "Every item has this key anyway.")
    if name in manifest["cameras"]:
        return Stream(name, "image")
    families: tuple[tuple[str, Kind], ...] = (
        ("aligned" if unit == "frame" else "signals", "aligned" if unit == "frame" else "signal"),
        ("frame_values", "frame_value"),
    )
    for family, kind in families:
        if name in manifest[family]:
            facts = manifest[family][name]
            return Stream(name, kind, tuple(facts["columns"]), tuple(facts["units"]))
    if name == BACKGROUND:
        return Stream(name, "background")
    if name == MESH:
        raise StoreError(
            f"the store {store.location} has no meshes",
            "a mesh for every frame",
            "Run `tactiledata replay` to attach them, or leave 'mesh' out of the streams.",
        )
    raise UnknownName("stream", name, known(store), "`tactiledata info` shows the streams of a store.")
