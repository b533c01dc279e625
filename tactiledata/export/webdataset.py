"""WebDataset: tar files of samples, a picture and its numbers a frame, to be streamed."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tactiledata.contract.provenance import json_bytes
from tactiledata.export.base import ExportedFile, Exporter, FileFacts, count, files_by_part, no_counts
from tactiledata.export.episodes import Episodes, FrameBatch
from tactiledata.export.parquet_rows import SUFFIX
from tactiledata.export.plan import MEGABYTE, ExportPlan

SHOWN = 5
"""Digits of a shard's number."""


class WebDatasetExporter(Exporter):
    """Writes tar files of pictures and JSON documents."""

    name = "webdataset"
    title = "WebDataset: tar files of pictures and JSON"
    lost: ClassVar = (
        "Samples between the frames: a sample has the values at the moment of its frame. The store has them at native "
        "rate.",
        "Frames without a readable image are no samples, nor are frames outside any trajectory.",
        "Order within a touch, once a loader shuffles: `trajectory` and `frame_index` of a sample restore it.",
        "Meshes of `tactiledata replay` stay in the store.",
    )

    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return the shards, numbered within each part."""
        return files_by_part(
            episodes, plan.file_mb * MEGABYTE, lambda part, number, _: f"{part}-{number:0{SHOWN}d}.tar"
        )

    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write the samples of some episodes.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        file : ExportedFile
            Which of it.
        path : Path
            Where the file is written.
        advance : callable
            Called with the number of frames written since the last call.
        """
        noted = no_counts()
        with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as shard:
            for batch in episodes.batches(file.start, file.stop):
                count(noted, batch)
                for place in range(len(batch)):
                    key = f"{episodes.facts.uids[batch.episode]}_{batch.first + place:06d}"
                    content, kind, _ = batch.pictures[place]
                    _add(shard, f"{key}.{SUFFIX[kind]}", content)
                    _add(shard, f"{key}.json", json_bytes(self._facts(episodes, batch, place)))
                advance(len(batch))
        return noted

    def _facts(self, episodes: Episodes, batch: FrameBatch, place: int) -> dict[str, Any]:
        """Return what is known of a frame beside its picture, as JSON values; ``null`` where nothing was recorded."""
        facts, episode = episodes.facts, batch.episode
        return {
            "trajectory": facts.uids[episode],
            "part": episodes.parts[episode],
            "sensor": facts.sensors[episode],
            "indenter": facts.indenters[episode],
            "recorded": facts.kinds[episode],
            "frame": int(batch.rows[place]),
            "frame_index": batch.first + place,
            "t_ns": int(batch.t_ns[place]),
            "in_split": bool(batch.in_split[place]),
            "values": {
                name: [float(value) if np.isfinite(value) else None for value in values[place]]
                for name, values in batch.values.items()
            },
        }

    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return where a sample has the stream."""
        return "jpg or png" if stream == episodes.camera else f"json: values.{stream}"

    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines that stream the first part."""
        part = episodes.parts[0]
        last = sum(episodes.parts[file.start] == part for file in files) - 1
        shards = f"{part}-{{{0:0{SHOWN}d}..{last:0{SHOWN}d}}}.tar"
        return "\n".join(
            [
                "import webdataset",
                "",
                f'samples = webdataset.WebDataset("{shards}", shardshuffle=False).decode("rgb8")',
                'for picture, facts in samples.to_tuple("jpg;png", "json"):',
                '    print(picture.shape, facts["trajectory"], facts["values"])',
                "    break",
            ]
        )


def _add(shard: tarfile.TarFile, name: str, content: bytes) -> None:
    """Add a file to a tar file, without time, owner or anything else that differs between machines."""
    info = tarfile.TarInfo(name)
    info.size = len(content)
    shard.addfile(info, io.BytesIO(content))
