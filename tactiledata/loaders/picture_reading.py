"""How a dataset reads its pictures: at which size, and with which cache of decoded ones."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.loaders.cache_room import claim
from tactiledata.loaders.decoded_cache import DecodedCache
from tactiledata.loaders.index import FrameIndex
from tactiledata.loaders.streams import Stream
from tactiledata.store.read.scaled_pictures import average_into, need_smaller

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class PictureReading:
    """Reads pictures of frames, and those of sensors without contact, at one size.

    Parameters
    ----------
    size : (rows, columns), optional
        ``None`` for pictures as stored.
    cache : DecodedCache, optional
    note : str
        What to report of the cache; may be empty.
    """

    size: tuple[int, int] | None = None
    cache: DecodedCache | None = None
    note: str = ""

    def of_frames(self, store: Store, rows: NDArray[np.int64], threads: int | None) -> NDArray[np.uint8]:
        """Return pictures (n, h, w, 3) of frames.

        Parameters
        ----------
        store : Store
            Where they are.
        rows : (n,) int64
            Rows of frames.
        threads : int, optional
            Threads that decode.
        """
        return np.asarray(store.images(rows, threads=threads, size=self.size, kept=self.cache))

    def of_sensors(self, store: Store) -> dict[str, NDArray[np.uint8]]:
        """Pictures (h, w, 3) without contact, by sensor."""
        return {sensor: self._sized(reference.image) for sensor, reference in store.references().items()}

    def _sized(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        if self.size is None:
            return picture
        smaller = np.empty((*self.size, 3), np.uint8)
        average_into(picture, smaller)
        return smaller


def picture_reading(
    store: Store,
    index: FrameIndex,
    streams: Iterable[Stream],
    size: Sequence[int] | None,
    cache: str | os.PathLike[str] | None,
    cache_bytes: int,
) -> PictureReading:
    """Return how the pictures of a dataset are read, with room claimed in the cache where one is named.

    Parameters
    ----------
    store : Store
        Where the pictures are.
    index : FrameIndex
        Frames of the dataset, whose pictures have one size.
    streams : iterable of Stream
        Streams of the dataset.
    size : (rows, columns), optional
        A smaller size that is asked for.
    cache : path, optional
        Folder of decoded pictures.
    cache_bytes : int
        What all caches of that folder may take.

    Raises
    ------
    UsageError
        A size that is larger than a picture, a folder that cannot be used, or either without pictures.
    """
    kinds = {stream.kind for stream in streams}
    if cache is not None and (not isinstance(cache, str | os.PathLike) or str(cache) == "" or "://" in str(cache)):
        raise UsageError(f"cache={cache!r}", "a folder on a local disk", "For example cache='decoded'.")
    if cache is not None and "image" not in kinds:
        raise UsageError("a cache for a dataset without pictures of a camera", "a camera among the streams")
    if size is not None and not kinds & {"image", "background"}:
        raise UsageError("an image_size for a dataset without pictures", "a camera or 'background' among the streams")
    shapes = []
    if "image" in kinds:
        shapes.append(store.image_shape(int(index.rows[0])))
    if "background" in kinds and size is not None:
        references = store.references()
        shapes += [references[sensor].image.shape[:2] for sensor in index.sensor_names]
    checked = None if size is None else need_smaller(size, (min(h for h, _ in shapes), min(w for _, w in shapes)))
    if cache is None:
        return PictureReading(checked)
    shape = (*(checked or shapes[0]), 3)
    return PictureReading(checked, *claim(cache, cache_bytes, store, index.rows, shape))
