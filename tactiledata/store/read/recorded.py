"""Whether rows that hold nothing were recorded so: a chunk whose file is gone reads as rows that hold nothing."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import google_crc32c
import numpy as np
import pyarrow as pa

from tactiledata.errors import StoreError
from tactiledata.store.layout.places import (
    ALIGNED_ARRAYS,
    SIGNAL_ARRAYS,
    aligned_path,
    frame_values_path,
    signal_path,
)
from tactiledata.store.read.files import StoreFiles
from tactiledata.store.read.rows import Rows


def recorded_spans(home: str, key: str, contents: str, frames: tuple[int, int]) -> list[tuple[str, int, int, int]]:
    """Return arrays, first rows, stops and CRC-32C of the numbers of one source, as the table of sources has them.

    Parameters
    ----------
    home : str
        Folder of the arrays in the store.
    key, contents : str
        Of the source's row.
    frames : (first, stop)
        Its rows in the table of frames.

    Raises
    ------
    StoreError
        The contents cannot be read.
    """
    try:
        return list(_spans(home, json.loads(contents), frames))
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise StoreError(
            f"what the table of sources says of {key} cannot be read: {error}",
            "rows and checksums of each array",
            "Run `tactiledata check` on the store; restore the file from a copy.",
        ) from error


def _spans(home: str, contents: Mapping[str, Any], frames: tuple[int, int]) -> Iterator[tuple[str, int, int, int]]:
    for name, facts in contents.get("signals", {}).items():
        yield from ((signal_path(home, name, array), *facts["rows"], facts["crc32c"][array]) for array in SIGNAL_ARRAYS)
    for name, facts in contents.get("aligned", {}).items():
        yield from ((aligned_path(home, name, array), *frames, facts["crc32c"][array]) for array in ALIGNED_ARRAYS)
    for name, facts in contents.get("frame_values", {}).items():
        yield frame_values_path(home, name), *frames, facts["crc32c"]["value"]


class RecordedNumbers:
    """Refuses rows that read as nothing where something was recorded.

    Zarr writes no file for a chunk that holds nothing but the fill value, so that a chunk that was deleted looks like
    one in which nothing was recorded. The checksums of the sources tell them apart.

    Parameters
    ----------
    files : StoreFiles
    home : str
        Folder of the arrays in the store.
    sources : callable
        Returns columns of the table of sources.
    """

    def __init__(self, files: StoreFiles, home: str, sources: Callable[[Sequence[str]], pa.Table]) -> None:
        self._files, self._home, self._sources = files, home, sources
        self._spans: dict[str, list[tuple[str, int, int, int]]] | None = None

    def rows(self, path: str, length: int) -> Rows:
        """The first rows of an array; rows that hold nothing are checked as they are read."""
        return Rows(self._files, path, length, self._need)

    def _need(self, path: str, start: int, stop: int) -> None:
        """Raise `StoreError` where rows [start, stop) of an array, which read as nothing, are not what was recorded."""
        if self._spans is None:
            self._spans = self._read()
        for key, first, last, crc in self._spans.get(path, []):
            if first >= stop or last <= start or first == last:
                continue
            values = np.ascontiguousarray(Rows(self._files, path, last).span(first, last))
            if google_crc32c.value(values.tobytes()) != crc:
                raise StoreError(
                    f"a chunk of array {path} in {self._files.location} is missing: rows {first} to {last} of {key} do "
                    "not fit their CRC-32C",
                    "the numbers that were ingested",
                    "Run `tactiledata check` to see what it concerns; restore the file from a copy.",
                )

    def _read(self) -> dict[str, list[tuple[str, int, int, int]]]:
        found: dict[str, list[tuple[str, int, int, int]]] = {}
        stop = 0
        for source in self._sources(["key", "frames", "contents"]).to_pylist():
            frames = (stop, stop + source["frames"])
            stop = frames[1]
            for path, first, last, crc in recorded_spans(self._home, source["key"], source["contents"], frames):
                found.setdefault(path, []).append((source["key"], first, last, crc))
        return found
