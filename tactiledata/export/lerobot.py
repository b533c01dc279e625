"""LeRobot datasets, version 3: an episode a touch, a row a frame, pictures inside the parquet files."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.export.base import ExportedFile, Exporter, FileFacts, count, no_counts
from tactiledata.export.episode_statistics import NAMES, combined, picture_statistics, statistics
from tactiledata.export.episodes import Episodes, FrameBatch
from tactiledata.export.meanings import robot_model
from tactiledata.export.parquet_rows import SUFFIX, RowField, pictures, schema_of, vectors, write_rows
from tactiledata.export.plan import MEGABYTE, ExportPlan
from tactiledata.loaders.fit import require_one_size

VERSION = "v3.0"
CHUNK_FILES = 1000
"""Files of one chunk folder."""
FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
STATE = ("tcp", "joints")
"""The first of these that goes out is the robot's state."""
KIND = "float32"
SCALARS = {"t_ns": "int64", "in_split": "bool"}
OWN = {**SCALARS, "timestamp": KIND, **dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64")}
"""Columns of a row beside pictures and values: ours, then those that LeRobot asks for."""
SAMPLED_PICTURES = 16
"""Pictures of an episode from which its statistics are taken, evenly spaced."""
EPISODES_A_FILE = 5000
SECOND = 10**9


class LeRobotExporter(Exporter):
    """Writes a LeRobot dataset, version 3."""

    name = "lerobot"
    title = "LeRobot dataset v3: an episode a touch, pictures in parquet"
    lost: ClassVar = (
        "Samples between the frames: a row has the values at the moment of its frame. The store has them at native "
        "rate.",
        "Uneven frame times: `timestamp` is the frame's number over fps, as LeRobot expects; the true time is `t_ns`.",
        "Digits: numbers are float32, as LeRobot's policies take them.",
        "Frames without a readable image have no row, nor have frames outside any trajectory.",
        "LeRobot names splits in `meta/info.json` and does not follow them: name the episodes of a part yourself.",
        "Meshes of `tactiledata replay` stay in the store.",
    )

    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return the data files."""
        require_one_size(episodes.store, episodes.index, episodes.camera)
        return [
            ExportedFile(f"data/{_file(number)}.parquet", start, stop, int(episodes.lengths[start:stop].sum()))
            for number, (start, stop) in enumerate(episodes.groups(plan.file_mb * MEGABYTE))
        ]

    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write the rows of some episodes, and note the statistics of each.

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
        found: list[dict[str, Any]] = []
        _, task_of = _tasks(episodes)
        fps = frames_per_second(episodes)

        def rows() -> Iterator[Mapping[str, Any]]:
            """Yield the columns of each batch of frames, and keep the numbers of the episode for its statistics."""
            held: list[dict[str, Any]] = []
            for batch in episodes.batches(file.start, file.stop):
                count(noted, batch)
                columns = self._columns(episodes, batch, task_of[batch.episode], fps)
                held.append({name: value for name, value in columns.items() if isinstance(value, np.ndarray)})
                yield {
                    name: vectors(value, KIND) if isinstance(value, np.ndarray) and value.ndim == 2 else value
                    for name, value in columns.items()
                }
                advance(len(batch))
                if batch.first + len(batch) == episodes.lengths[batch.episode]:
                    found.append(self._statistics(episodes, batch.episode, held))
                    held = []

        write_rows(path, schema_of(self._fields(episodes)), rows())
        return {**noted, "statistics": found}

    def _fields(self, episodes: Episodes) -> list[RowField]:
        """Return the columns of the data files."""
        fields = [RowField.picture(self.kept_as(episodes.camera, episodes))]
        for stream in episodes.streams:
            facts = episodes.stream_facts[stream.name]
            fields.append(RowField.vector(self.kept_as(stream.name, episodes), KIND, len(stream.columns), facts))
        if episodes.action is not None:
            fields.append(RowField.vector("action", KIND, len(episodes.action.columns)))
        return fields + [RowField.scalar(name, kind) for name, kind in OWN.items()]

    def _columns(self, episodes: Episodes, batch: FrameBatch, task: int, fps: int) -> dict[str, Any]:
        """Return the columns of a batch by name."""
        frame_index = np.arange(batch.first, batch.first + len(batch))
        columns: dict[str, Any] = {
            name if name == "action" else self.kept_as(name, episodes): values.astype(np.float32)
            for name, values in batch.values.items()
        }
        names = [f"frame-{batch.first + place:06d}.{SUFFIX[kind]}" for place, (_, kind, _) in enumerate(batch.pictures)]
        columns[self.kept_as(episodes.camera, episodes)] = pictures([each[0] for each in batch.pictures], names)
        return {
            **columns,
            "t_ns": batch.t_ns,
            "in_split": batch.in_split,
            "timestamp": (frame_index / fps).astype(np.float32),
            "frame_index": frame_index,
            "episode_index": np.full(len(batch), batch.episode),
            "index": frame_index + int(episodes.index.starts[batch.episode]),
            "task_index": np.full(len(batch), task),
        }

    def _statistics(self, episodes: Episodes, episode: int, held: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Return the statistics of an episode by feature."""
        columns = {name: np.concatenate([batch[name] for batch in held]) for name in held[0]}
        found = {name: statistics(column.reshape(len(column), -1)) for name, column in columns.items()}
        start, stop = episodes.index.starts[episode : episode + 2]
        places = np.unique(np.linspace(start, stop - 1, SAMPLED_PICTURES).round().astype(int))
        sampled = np.asarray(episodes.store.images(episodes.index.rows[places]))
        found[self.kept_as(episodes.camera, episodes)] = picture_statistics(sampled)
        return found

    def finish(
        self,
        episodes: Episodes,
        files: Sequence[ExportedFile],
        facts: Callable[[], Iterator[FileFacts]],
        folder: Path,
    ) -> None:
        """Write what LeRobot keeps in `meta`: info, tasks, episodes and statistics.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        files : sequence of ExportedFile
            The large files.
        facts : callable
            Gives what was noted of each of them.
        folder : Path
            Where the export is made.
        """
        tasks, task_of = _tasks(episodes)
        write_json_atomic(folder / "meta" / "info.json", self._info(episodes, tasks))
        table = pd.DataFrame({"task_index": range(len(tasks))}, index=tasks)
        buffer = io.BytesIO()
        table.to_parquet(buffer)
        write_atomic(folder / "meta" / "tasks.parquet", buffer.getvalue())
        every = (found for each in facts() for found in each["statistics"])
        write_json_atomic(folder / "meta" / "stats.json", combined(every))
        self._write_episodes(episodes, files, facts, folder, [tasks[number] for number in task_of])

    def _info(self, episodes: Episodes, tasks: Sequence[str]) -> dict[str, Any]:
        """Return the content of `meta/info.json`."""
        height, width = episodes.picture_sizes[0].tolist()
        picture = {"dtype": "image", "shape": [height, width, 3], "names": ["height", "width", "channels"]}
        features: dict[str, Any] = {self.kept_as(episodes.camera, episodes): picture}
        for stream in episodes.streams:
            facts = episodes.stream_facts[stream.name]
            features[self.kept_as(stream.name, episodes)] = {
                "dtype": KIND, "shape": [len(stream.columns)], "names": facts["columns"], "units": facts["units"],
                "frame": facts["frame"], "meaning": facts["meaning"],
            }  # fmt: skip
        if episodes.action is not None:
            columns = list(episodes.action.columns)
            features["action"] = {"dtype": KIND, "shape": [len(columns)], "names": columns}
        for name, kind in OWN.items():
            features[name] = {"dtype": kind, "shape": [1], "names": None}
        return {
            "codebase_version": VERSION,
            "robot_type": robot_model(episodes.store),
            "total_episodes": len(episodes),
            "total_frames": len(episodes.index.rows),
            "total_tasks": len(tasks),
            "chunks_size": CHUNK_FILES,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": frames_per_second(episodes),
            "splits": {part: f"{start}:{stop}" for part, (start, stop) in episodes.part_ranges().items()},
            "data_path": f"data/{FILE}.parquet",
            "video_path": None,
            "features": features,
        }

    def _write_episodes(
        self,
        episodes: Episodes,
        files: Sequence[ExportedFile],
        facts: Callable[[], Iterator[FileFacts]],
        folder: Path,
        tasks: Sequence[str],
    ) -> None:
        """Write the tables of episodes: where their rows lie, their statistics, and who touched what."""
        rows: list[dict[str, Any]] = []
        written = 0
        known = episodes.facts
        for number, (file, noted) in enumerate(zip(files, facts(), strict=True)):
            for episode, found in zip(range(file.start, file.stop), noted["statistics"], strict=True):
                start, stop = episodes.index.starts[episode : episode + 2].tolist()
                rows.append(
                    {
                        "episode_index": episode,
                        "tasks": [tasks[episode]],
                        "length": stop - start,
                        "data/chunk_index": number // CHUNK_FILES,
                        "data/file_index": number % CHUNK_FILES,
                        "dataset_from_index": start,
                        "dataset_to_index": stop,
                        "meta/episodes/chunk_index": written // CHUNK_FILES,
                        "meta/episodes/file_index": written % CHUNK_FILES,
                        "part": episodes.parts[episode],
                        "trajectory": known.uids[episode],
                        "trajectory_name": known.names[episode],
                        "sensor": known.sensors[episode],
                        "indenter": known.indenters[episode],
                        "recorded": known.kinds[episode],
                        **{
                            f"stats/{feature}/{name}": values[name]
                            for feature, values in found.items()
                            for name in (*NAMES, "count")
                        },
                    }
                )
                if len(rows) == EPISODES_A_FILE or episode == len(episodes) - 1:
                    buffer = pa.BufferOutputStream()
                    pq.write_table(pa.Table.from_pylist(rows), buffer, compression="zstd")
                    path = folder / "meta" / "episodes" / f"{_file(written)}.parquet"
                    write_atomic(path, buffer.getvalue().to_pybytes())
                    rows, written = [], written + 1

    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return the feature's name; the pose or the joints become `observation.state`."""
        plain = stream.replace("/", ".")
        if stream == episodes.camera:
            return f"observation.images.{plain}"
        state = next((name for name in STATE if any(name == each.name for each in episodes.streams)), "")
        return "observation.state" if stream == state else f"observation.{plain}"

    def remarks(self, episodes: Episodes) -> list[str]:
        """Return how uneven the frames are."""
        fps = frames_per_second(episodes)
        steps = _steps(episodes)
        if not len(steps):
            return []
        uneven = int((np.abs(steps * fps / SECOND - 1) > 0.1).sum())
        return [
            f"fps is {fps}, from the median step between frames. {uneven} of {len(steps)} steps differ from 1/fps by "
            f"more than a tenth; they take {steps.min() / 1e6:.0f} to {steps.max() / 1e6:.0f} ms."
        ]

    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines that read the episodes of the first part."""
        part, (start, stop) = next(iter(episodes.part_ranges().items()))
        camera = self.kept_as(episodes.camera, episodes)
        lines = [
            "from lerobot.datasets.lerobot_dataset import LeRobotDataset",
            "",
            f'dataset = LeRobotDataset("tactile", root=".", episodes=list(range({start}, {stop})))  # {part}',
            "frame = dataset[0]",
            f'print(frame["{camera}"].shape, frame["task"])',
        ]
        return "\n".join(lines)


def frames_per_second(episodes: Episodes) -> int:
    """Return the whole number of frames per second nearest to the median step between neighbouring frames."""
    steps = _steps(episodes)
    median = float(np.median(steps)) if len(steps) else 0.0
    return max(1, round(SECOND / median)) if median > 0 else 1


def _steps(episodes: Episodes) -> np.ndarray:
    """Return the times (m,), ns, between neighbouring frames of the same episode."""
    inside = np.ones(max(len(episodes.index.rows) - 1, 0), bool)
    inside[episodes.index.starts[1:-1] - 1] = False
    return np.diff(episodes.index.t_ns)[inside]


def _tasks(episodes: Episodes) -> tuple[list[str], list[int]]:
    """Return the tasks in words, and the number of each episode's task."""
    said = [f"touch {indenter}" if indenter else "touch" for indenter in episodes.facts.indenters]
    tasks = list(dict.fromkeys(said))
    numbers = {task: number for number, task in enumerate(tasks)}
    return tasks, [numbers[task] for task in said]


def _file(number: int) -> str:
    """Return the path of a numbered file, without its suffix."""
    return FILE.format(chunk_index=number // CHUNK_FILES, file_index=number % CHUNK_FILES)
