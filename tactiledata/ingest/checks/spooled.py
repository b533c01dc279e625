"""Images that are still in a spool, read back for references and checks before they are kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.errors import BrokenLog
from tactiledata.store.layout.shards import unpack_frame
from tactiledata.store.write.spool import PART_BYTES, spool_name


@dataclass(frozen=True)
class SpooledImages:
    """Images of a closed spool, by row in the order of the sink.

    Parameters
    ----------
    folder : Path
        The spool's folder.
    columns : pa.Table
        The spool's columns.
    """

    folder: Path
    columns: pa.Table

    def payload(self, row: int) -> tuple[str, bytes]:
        """Encoding and bytes of one image, as the spool keeps them (raw frames compressed)."""
        facts = self._facts(row)
        if facts["encoding"] == "missing":
            return "missing", b""
        name = spool_name(*(facts[fact] for fact in ("camera", "encoding", "height", "width", "offset")))
        with (self.folder / name).open("rb") as stream:
            stream.seek(facts["offset"] % PART_BYTES)
            return facts["encoding"], stream.read(facts["length"])

    def tails(self, rows: Sequence[int], length: int) -> list[bytes]:
        """The last bytes of each of some encoded images."""
        found = []
        streams = {}
        try:
            for row in rows:
                facts = self._facts(row)
                name = spool_name(facts["camera"], facts["encoding"], facts["height"], facts["width"])
                if name not in streams:
                    streams[name] = (self.folder / name).open("rb")
                size = min(length, facts["length"])
                streams[name].seek(facts["offset"] + facts["length"] - size)
                found.append(streams[name].read(size))
        finally:
            for stream in streams.values():
                stream.close()
        return found

    def decode(self, rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
        """Images (H, W, 3) RGB; ``None`` for one that is missing or does not decode."""
        return [self._decoded(int(row)) for row in rows]

    def _decoded(self, row: int) -> NDArray[np.uint8] | None:
        encoding, payload = self.payload(row)
        if encoding == "missing":
            return None
        if encoding == "raw":
            facts = self._facts(row)
            image = np.empty((facts["height"], facts["width"], 3), np.uint8)
            unpack_frame(payload, image)
            return image
        try:
            return decode_rgb(payload)
        except BrokenLog:
            return None

    def _facts(self, row: int) -> dict:
        return {
            name: self.columns[name][row].as_py()
            for name in ("camera", "encoding", "offset", "length", "height", "width")
        }
