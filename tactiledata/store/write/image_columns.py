"""A row of facts for each image on its way into a store, and what is refused of an image."""

from __future__ import annotations

from array import array
from collections.abc import Mapping

import numpy as np
import pyarrow as pa

from tactiledata.contract.records import Image
from tactiledata.contract.take import FRAME_SCHEMA
from tactiledata.errors import StoreError
from tactiledata.store.layout.places import Settings

ENCODINGS = ("jpeg", "png", "raw", "missing")
COLUMNS: dict[str, str] = {
    "offset": "q",
    "length": "q",
    "crc32c": "Q",
    "height": "q",
    "width": "q",
    "log_ns": "q",
    "publish_ns": "q",
    "header_ns": "q",
}
"""Columns of numbers, with their type codes in `array`."""
OWN = ("height", "width", "log_ns", "publish_ns", "header_ns")
"""Numbers that an image brings itself."""
NAMES = ("camera", "encoding", "sensor", "trajectory")
"""Columns of names, kept as codes."""


class ImageColumns:
    """Facts of images, about 100 bytes an image in memory.

    Parameters
    ----------
    largest_payload : int
        Bytes that an encoded image may have.
    """

    def __init__(self, largest_payload: int = Settings().heap_chunk_bytes) -> None:
        self.largest_payload = largest_payload
        self._numbers = {name: array(code) for name, code in COLUMNS.items()}
        self._codes = {name: array("i") for name in NAMES}
        self._names: dict[str, dict[str, int]] = {name: {} for name in NAMES}

    def __len__(self) -> int:
        return len(self._numbers["offset"])

    def add(self, image: Image, place: Mapping[str, int]) -> None:
        """Take the facts of one image; ``place`` has the offset, length and checksum of its bytes."""
        for name in COLUMNS:
            self._numbers[name].append(getattr(image, name) if name in OWN else place[name])
        for name in NAMES:
            known = self._names[name]
            self._codes[name].append(known.setdefault(getattr(image, name), len(known)))

    def table(self) -> pa.Table:
        """A row for each image, in the order in which they came.

        ``camera, encoding, sensor, trajectory`` (its name), ``offset, length`` (into the spool file), ``crc32c, height,
        width, log_ns, publish_ns, header_ns``; types as in ``FRAME_SCHEMA``, ``trajectory`` a dictionary of names.
        """
        columns: dict[str, pa.Array] = {}
        for name in NAMES:
            codes = pa.array(np.array(self._codes[name], dtype=np.int32))
            columns[name] = pa.DictionaryArray.from_arrays(codes, pa.array(list(self._names[name]), pa.string()))
        for name in COLUMNS:
            columns[name] = pa.array(np.array(self._numbers[name])).cast(FRAME_SCHEMA.field(name).type)
        return pa.table(columns)

    def check(self, image: Image, number: int) -> None:
        """Refuse an image that cannot be kept; ``number`` counts the images before it.

        Raises
        ------
        StoreError
            Its encoding, size, times or names are none that a store keeps, or its bytes do not fit them.
        """
        what = f"image {image.name or number} of camera {image.camera!r}"
        self._check_columns(image, what)
        if image.encoding not in ENCODINGS:
            raise StoreError(f"{what} has encoding {image.encoding!r}", f"one of {', '.join(ENCODINGS)}")
        if not (0 <= image.height < 2**15 and 0 <= image.width < 2**15):
            raise StoreError(f"{what} is {image.height}x{image.width} pixels", "at most 32767 a side")
        wanted = image.height * image.width * 3
        if image.encoding == "raw" and (len(image.payload) != wanted or not wanted):
            raise StoreError(
                f"{what} has {len(image.payload)} bytes",
                f"{image.height} x {image.width} x 3 = {wanted} bytes of RGB, more than none",
            )
        if image.encoding != "raw" and len(image.payload) > self.largest_payload:
            raise StoreError(
                f"{what} has {len(image.payload)} bytes",
                f"at most {self.largest_payload} bytes an encoded image",
                "Record smaller images.",
            )

    def _check_columns(self, image: Image, what: str) -> None:
        for name in ("log_ns", "publish_ns", "header_ns"):
            if not -(2**63) <= getattr(image, name) < 2**63:
                raise StoreError(f"{what} has {name} {getattr(image, name)}", "nanoseconds that fit 64 bits")
        for name in NAMES:
            try:
                getattr(image, name).encode()
            except UnicodeEncodeError as error:
                raise StoreError(f"{what} has {name} {getattr(image, name)!r}", "text that is Unicode") from error
