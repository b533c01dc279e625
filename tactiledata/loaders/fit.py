"""Whether the frames of a dataset fit together: one size of pictures, a background for every sensor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.errors import StoreError, UsageError
from tactiledata.loaders.index import FrameIndex
from tactiledata.loaders.streams import Stream

SENSORS_DIFFER = "Give sensors with other pictures another camera name in the mapping, and ingest again with --replace."
"""What to do where each sensor has one size."""
RECORDINGS_DIFFER = (
    "Ingest that recording again with --replace: single frames of another size are then marked and left out. A whole "
    "recording of another size needs another camera name in its mapping, or images scaled to one size."
)
"""What to do where one sensor's pictures differ in size."""

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


def require_references(store: Store, index: FrameIndex, streams: Iterable[Stream]) -> None:
    """Refuse a dataset that asks for pictures without contact of sensors that have none.

    Parameters
    ----------
    store : Store
        Where the pictures are.
    index : FrameIndex
        Frames of the dataset, with their sensors.
    streams : iterable of Stream
        Streams of the dataset; nothing is refused where no background is among them.

    Raises
    ------
    StoreError
        Sensors without such a picture; the message names them.
    """
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
    """Refuse a dataset whose pictures of one camera have several sizes and cannot be stacked.

    Parameters
    ----------
    store : Store
        Where the frames are.
    index : FrameIndex
        Frames of the dataset.
    camera : str, optional
        Camera whose pictures are asked for; ``None`` where no pictures are.

    Raises
    ------
    UsageError
        Several sizes; the message counts them and names the first frame of the rarest.
    """
    if camera is None:
        return
    frames = store.frames(["height", "width"]).take(index.rows)
    height, width = (frames[name].to_numpy().astype(np.int64) for name in ("height", "width"))
    sizes, kind, counts = np.unique(np.stack([height, width], axis=1), axis=0, return_inverse=True, return_counts=True)
    if len(sizes) < 2:
        return
    kind = kind.reshape(-1)
    by_count = np.argsort(-counts)
    listed = ", ".join(f"{counts[size]} of {sizes[size][0]} x {sizes[size][1]}" for size in by_count)
    rarest = int(by_count[-1])
    place = int(np.flatnonzero(kind == rarest)[0])
    where = f"frame {index.rows[place]}, in trajectory {_trajectory_name(store, int(index.trajectory[place]))}"
    sensors = [{index.sensor_code[place] for place in np.flatnonzero(kind == size)} for size in range(len(sizes))]
    is_by_sensor = sum(map(len, sensors)) == len(set.union(*sensors))
    raise UsageError(
        f"the frames of camera {camera!r} have several sizes (rows x columns): {listed}; the first of the rarest is "
        f"{where}",
        "one size, so that they can be stacked",
        SENSORS_DIFFER if is_by_sensor else RECORDINGS_DIFFER,
    )


def _trajectory_name(store: Store, trajectory: int) -> str:
    """Name of a trajectory and key of its recording, for people."""
    if trajectory < 0:
        return "none"
    facts = store.trajectories(["trajectory", "source"]).slice(trajectory, 1).to_pylist()[0]
    key = store.sources(["key"])["key"][facts["source"]].as_py()
    return f"{facts['trajectory']!r} of {key}"
