"""Images of a group of takes on their way into a store: each camera's heap and shards, appended take by take."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import zarr

from tactiledata.arrays import Indices
from tactiledata.store.layout.arrays import create_frames, create_heap, set_length
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.images import HeapAppender, ShardAppender
from tactiledata.store.layout.manifest import Manifest, settings_of
from tactiledata.store.layout.places import heap_path, rgb_path
from tactiledata.store.write.spool import PART_BYTES, spool_name
from tactiledata.store.write.writer import StagedTake


class ImageAppender:
    """Copies the payloads of takes to the end of the store's heaps and shards.

    Parameters
    ----------
    batch : Batch
    root : zarr.Group
        The store's group, to create arrays in.
    manifest : dict
        Changed in place.
    """

    def __init__(self, batch: Batch, root: zarr.Group, manifest: Manifest) -> None:
        self._batch, self._root = batch, root
        self._cameras = manifest["cameras"]
        self._settings = settings_of(manifest)
        self._heaps: dict[str, HeapAppender] = {}
        self._shards: dict[tuple[str, int, int], ShardAppender] = {}

    def add(self, take: StagedTake, frames: pa.Table) -> tuple[Indices, Indices]:
        """Offset and length of each frame in the store, as the frames table keeps them."""
        encoding = np.array(frames["encoding"].cast(pa.string()).to_pylist(), dtype=object)
        camera = np.array(frames["camera"].cast(pa.string()).to_pylist(), dtype=object)
        height, width = np.asarray(frames["height"]), np.asarray(frames["width"])
        read_at, n_read, crc32c = (np.asarray(frames[name]) for name in ("offset", "length", "crc32c"))
        offset, length = np.full(len(frames), -1, dtype=np.int64), np.zeros(len(frames), dtype=np.int64)
        for name in dict.fromkeys(camera.tolist()):
            self._cameras.setdefault(name, {"heap_bytes": 0, "rgb": {}})
            encoded = np.flatnonzero((camera == name) & (encoding != "raw") & (encoding != "missing"))
            if len(encoded):
                spool = take.folder / spool_name(name, "jpeg", 0, 0)
                offset[encoded] = self._heap(name).append(spool, read_at[encoded], n_read[encoded], crc32c[encoded])
                length[encoded] = n_read[encoded]
            raw = np.flatnonzero((camera == name) & (encoding == "raw"))
            # in the order of the recording, in which whole files of the spool become shards
            raw = raw[np.argsort(read_at[raw], kind="stable")]
            for size in dict.fromkeys(zip(height[raw].tolist(), width[raw].tolist(), strict=True)):
                chosen = raw[(height[raw] == size[0]) & (width[raw] == size[1])]
                shard, part = self._shard(name, *size), read_at[chosen] // PART_BYTES
                for run in np.split(chosen, np.flatnonzero(np.diff(part)) + 1):
                    spool = take.folder / spool_name(name, "raw", *size, int(read_at[run[0]]))
                    offset[run] = shard.append(spool, read_at[run] % PART_BYTES, n_read[run])
        return offset, length

    def finish(self) -> None:
        """Heaps and shards closed, lengths set."""
        for camera, heap in self._heaps.items():
            heap.close()
            self._cameras[camera]["heap_bytes"] = heap.end
            set_length(self._batch, heap_path(camera), heap.end)
        for (camera, height, width), shard in self._shards.items():
            shard.close()
            self._cameras[camera]["rgb"][f"{height}x{width}"] = shard.count
            set_length(self._batch, rgb_path(camera, height, width), shard.count)

    def _heap(self, camera: str) -> HeapAppender:
        if camera not in self._heaps:
            used = self._cameras[camera]["heap_bytes"]
            path = heap_path(camera)
            if not used:
                create_heap(self._root, path, self._settings.heap_chunk_bytes)
            self._heaps[camera] = HeapAppender(self._batch, path, self._settings.heap_chunk_bytes, used)
        return self._heaps[camera]

    def _shard(self, camera: str, height: int, width: int) -> ShardAppender:
        key = (camera, height, width)
        if key not in self._shards:
            used = self._cameras[camera]["rgb"].get(f"{height}x{width}", 0)
            path = rgb_path(*key)
            capacity = self._settings.frames_per_shard(height, width)
            if not used:
                create_frames(self._root, path, (height, width), capacity)
            self._shards[key] = ShardAppender(self._batch, path, capacity, used)
        return self._shards[key]
