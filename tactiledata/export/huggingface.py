"""Parquet files with pictures for Hugging Face's `datasets`: a row a frame, a split a part."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import yaml

from tactiledata.export.base import ExportedFile, Exporter, FileFacts, count, files_by_part, no_counts
from tactiledata.export.episodes import Episodes, FrameBatch
from tactiledata.export.parquet_rows import SUFFIX, RowField, pictures, schema_of, vectors, write_rows
from tactiledata.export.plan import MEGABYTE, ExportPlan

OWN = ("t_ns", "frame", "frame_index", "in_split", "trajectory", "sensor", "indenter", "recorded")
"""Columns that every row has."""
KIND = "float64"


class HuggingFaceExporter(Exporter):
    """Writes parquet files with pictures for `datasets`."""

    name = "huggingface"
    title = "Hugging Face datasets: parquet with pictures"
    lost: ClassVar = (
        "Samples between the frames: a row has the values at the moment of its frame. The store has them at native "
        "rate.",
        "Frames without a readable image have no row, nor have frames outside any trajectory.",
        "Meshes of `tactiledata replay` stay in the store.",
    )

    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return the parquet files; their names count those of each part."""
        return files_by_part(
            episodes,
            plan.file_mb * MEGABYTE,
            lambda part, number, count: f"data/{part}-{number:05d}-of-{count:05d}.parquet",
        )

    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write the rows of some episodes, and count missing values.

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

        def rows() -> Iterator[Mapping[str, Any]]:
            """Yield the columns of each batch of frames."""
            for batch in episodes.batches(file.start, file.stop):
                count(noted, batch)
                yield self._columns(episodes, batch)
                advance(len(batch))

        write_rows(path, schema_of(self._fields(episodes)), rows())
        return noted

    def _fields(self, episodes: Episodes) -> list[RowField]:
        """Return the columns of a row: picture, values, then who, what and when."""
        fields = [RowField.picture(self.kept_as(episodes.camera, episodes))]
        for stream in episodes.streams:
            facts = episodes.stream_facts[stream.name]
            fields.append(RowField.vector(self.kept_as(stream.name, episodes), KIND, len(stream.columns), facts))
        if episodes.action is not None:
            fields.append(RowField.vector("action", KIND, len(episodes.action.columns)))
        scalars = {"t_ns": "int64", "frame": "int64", "frame_index": "int64", "in_split": "bool"}
        return fields + [RowField.scalar(name, scalars.get(name, "string")) for name in OWN]

    def _columns(self, episodes: Episodes, batch: FrameBatch) -> dict[str, Any]:
        """Return the columns of a batch by name."""
        size, episode, facts = len(batch), batch.episode, episodes.facts
        uid = facts.uids[episode]
        columns: dict[str, Any] = {
            "t_ns": batch.t_ns,
            "frame": batch.rows,
            "frame_index": np.arange(batch.first, batch.first + size),
            "in_split": batch.in_split,
            "trajectory": [uid] * size,
            "sensor": [facts.sensors[episode]] * size,
            "indenter": [facts.indenters[episode]] * size,
            "recorded": [facts.kinds[episode]] * size,
        }
        for name, values in batch.values.items():
            columns[name if name == "action" else self.kept_as(name, episodes)] = vectors(values, KIND)
        names = [f"{uid}_{batch.first + place:06d}.{SUFFIX[kind]}" for place, (_, kind, _) in enumerate(batch.pictures)]
        columns[self.kept_as(episodes.camera, episodes)] = pictures([each[0] for each in batch.pictures], names)
        return columns

    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return the stream's own name; one that every row uses for something else gets an underscore."""
        return f"{stream}_" if stream in (*OWN, "action") else stream

    def front_matter(self, episodes: Episodes, files: Sequence[ExportedFile], key: str) -> str:
        """Return the lines that tell `datasets` which files are which split, and which export this is.

        `datasets` caches what it read by the folder's name and these lines, not by the files: without the key, another
        export of that name would be answered with the rows of the first.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        files : sequence of ExportedFile
            The parquet files.
        key : str
            Digest of all that decides the bytes.
        """
        data_files = [{"split": part, "path": f"data/{part}-*.parquet"} for part in episodes.part_ranges()]
        config = {"config_name": "default", "description": f"export {key}", "data_files": data_files}
        return yaml.safe_dump({"configs": [config], "tags": ["tactile"]}, sort_keys=False)

    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines that read the first part."""
        part = next(iter(episodes.part_ranges()))
        return "\n".join(
            [
                "from pathlib import Path",
                "",
                "from datasets import load_dataset",
                "",
                f'frames = load_dataset(str(Path.cwd()), split="{part}")',
                'taken = frames.filter(lambda row: row["in_split"])  # what the split\'s contact filter takes',
                f'print(frames[0]["{self.kept_as(episodes.camera, episodes)}"].size, len(taken))',
            ]
        )
