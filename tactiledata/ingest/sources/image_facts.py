"""A sink that keeps facts of images and not the images: what ingest can say of them before it takes any."""

from __future__ import annotations

import google_crc32c
import pyarrow as pa

from tactiledata.contract.records import Image
from tactiledata.ingest.checks.checks import ends_early
from tactiledata.store.write.image_columns import ImageColumns


class ImageFacts:
    """Facts of images as a spool has them; an image that came without bytes is taken for a whole one of its own."""

    def __init__(self) -> None:
        self._columns = ImageColumns()
        self.cut: list[int] = []
        """Rows of images that end too early."""

    def __len__(self) -> int:
        return len(self._columns)

    def add(self, image: Image) -> None:
        """Take the facts of one image.

        Raises
        ------
        StoreError
            The image is one that ingest would refuse.
        """
        row, is_opened = len(self), bool(image.payload)
        if is_opened:
            self._columns.check(image, row)
            if ends_early(image.encoding, image.payload):
                self.cut.append(row)
        # pictures that nobody opened are not taken for copies of one another
        crc = google_crc32c.value(image.payload) if is_opened else row
        self._columns.add(image, {"offset": 0, "length": len(image.payload), "crc32c": crc})

    def table(self) -> pa.Table:
        """A row for each image, as `ImageColumns.table` has it."""
        return self._columns.table()
