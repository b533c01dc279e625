"""Our store as a contestant, read by the real loader."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from contestants import Contestant, Pixels


class OurLoader(Contestant):
    """`TactileArrays`, all frames, pictures as uint8 (as the others give them)."""

    def __init__(self, folder: Path, threads: int) -> None:
        from tactiledata.loaders.numpy import TactileArrays

        self._arrays = TactileArrays(folder, "all", ("digit",), image_dtype="uint8", allow_leaks=True, threads=threads)

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows and pixels."""
        return rows, self._arrays.batch(rows)["digit"]
