"""Whether the frames of a dataset fit together: one size of pictures, a background for every sensor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tactiledata.errors import StoreError, UsageError
from tactiledata.loaders.index import FrameIndex
from tactiledata.loaders.streams import Stream

if TYPE_CHECKING:
    from tactiledata.store.reader import Store


def require_references(store: Store, index: FrameIndex, streams: Iterable[Stream]) -> None:
    """Nothing, where backgrounds are not asked for or every sensor has one; else `StoreError`."""
    if not any(stream.kind == "background" for stream in streams):
        return
    lacking = sorted(set(index.sensor_names) - set(store.manifest["references"]))
    if lacking:
        names = ", ".join(map(repr, lacking))
        raise StoreError(
            f"the store {store.location} has no picture without contact of sensor {names}",
            "a background for every sensor",
            "Add it with `tactiledata sensors add NAME --background FILE`.",
            sensors=lacking,
        )


def require_one_size(store: Store, index: FrameIndex, camera: str | None) -> None:
    """Nothing, where the pictures of the camera can be stacked; else `UsageError`."""
    if camera is None:
        return
    frames = store.frames(["height", "width"]).take(index.rows)
    sizes = frames.group_by(["height", "width"]).aggregate([([], "count_all")]).to_pylist()
    if len(sizes) > 1:
        listed = ", ".join(f"{size['count_all']} of {size['height']} x {size['width']}" for size in sizes)
        raise UsageError(
            f"the frames of camera {camera!r} have several sizes: {listed}",
            "one size, so that they can be stacked",
            "Give sensors with other pictures another camera name in the mapping, and ingest again.",
        )
