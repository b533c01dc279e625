"""HDF5 as robomimic reads it: a demonstration a touch, observations and actions, filter keys for the parts."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar

import h5py
import numpy as np

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.export.base import ExportedFile, Exporter, FileFacts, count, no_counts
from tactiledata.export.episodes import Episodes, FrameBatch
from tactiledata.export.plan import ExportPlan

FILE = "demonstrations.hdf5"
FILTER_KEYS = {"val": "valid"}
"""Parts that robomimic calls otherwise."""
NO_ENVIRONMENT = {"env_name": "recorded touches", "type": 2, "env_kwargs": {}}
"""What stands where robomimic expects the simulator that recorded: it is read, and serves for no roll-out."""
SAME_FILE = b"."
"""Name by which a virtual data set of HDF5 means its own file, whatever the file is called."""


class RobomimicExporter(Exporter):
    """Writes an HDF5 file of demonstrations for robomimic."""

    name = "robomimic"
    title = "robomimic: HDF5 of demonstrations"
    lost: ClassVar = (
        "Samples between the frames: an observation has the values at the moment of its frame. The store has them at "
        "native rate.",
        "JPEG and PNG bytes: pictures are kept as pixels, as robomimic reads them.",
        "Frames without a readable image are left out, and so are frames outside any trajectory.",
        "Rewards: none were recorded, all are zero. `dones` is one at the last frame of a touch.",
        "An environment: none recorded the touches, so that no policy can be rolled out.",
        "Meshes of `tactiledata replay` stay in the store.",
    )

    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return the one file that robomimic's loader opens."""
        return [ExportedFile(FILE, 0, len(episodes), len(episodes.index.rows))]

    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write all demonstrations.

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
        with h5py.File(path, "w") as made:
            data = made.create_group("data")
            for batch in episodes.batches(file.start, file.stop):
                count(noted, batch)
                if not batch.first:
                    self._begin(episodes, data, batch.episode)
                self._fill(episodes, data[f"demo_{batch.episode}"], batch)
                advance(len(batch))
            data.attrs["total"] = len(episodes.index.rows)
            data.attrs["env_args"] = json.dumps(NO_ENVIRONMENT)
            for part, (start, stop) in episodes.part_ranges().items():
                names = np.array([f"demo_{number}" for number in range(start, stop)], dtype="S")
                made[f"mask/{FILTER_KEYS.get(part, part)}"] = names
        return {**noted, "remade": 0}  # all are pixels there

    def _begin(self, episodes: Episodes, data: h5py.Group, episode: int) -> None:
        """Make the empty arrays of a demonstration, and say who touched what."""
        demo = data.create_group(f"demo_{episode}")
        start, stop = episodes.index.starts[episode : episode + 2].tolist()
        count, facts = stop - start, episodes.facts
        said = {
            "num_samples": count,
            "part": episodes.parts[episode],
            "trajectory": facts.uids[episode],
            "sensor": facts.sensors[episode],
            "indenter": facts.indenters[episode],
            "recorded": facts.kinds[episode],
        }
        for name, value in said.items():
            demo.attrs[name] = value
        for stream in episodes.streams:
            made = demo.create_dataset(f"obs/{self.kept_as(stream.name, episodes)}", (count, len(stream.columns)), "f8")
            for name, value in episodes.stream_facts[stream.name].items():
                made.attrs[name] = " ".join(value) if isinstance(value, list) else value
        shape = (count, *episodes.picture_sizes[start].tolist(), 3)
        name = f"obs/{self.kept_as(episodes.camera, episodes)}"
        demo.create_dataset(name, shape, "u1", chunks=(1, *shape[1:]), compression="gzip", compression_opts=1)
        if episodes.action is not None:
            demo.create_dataset("actions", (count, len(episodes.action.columns)), "f8")
        demo["rewards"] = np.zeros(count)
        demo["dones"] = (np.arange(count) == count - 1).astype(np.int64)
        demo.create_dataset("t_ns", (count,), "i8")
        demo.create_dataset("in_split", (count,), "?")
        _add_next(demo)

    def _fill(self, episodes: Episodes, demo: h5py.Group, batch: FrameBatch) -> None:
        """Write a batch of frames into the arrays of their demonstration."""
        place = slice(batch.first, batch.first + len(batch))
        demo["t_ns"][place], demo["in_split"][place] = batch.t_ns, batch.in_split
        for name, values in batch.values.items():
            demo["actions" if name == "action" else f"obs/{self.kept_as(name, episodes)}"][place] = values
        for offset, (content, _, _) in enumerate(batch.pictures):
            demo[f"obs/{self.kept_as(episodes.camera, episodes)}"][batch.first + offset] = decode_rgb(content)

    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return the key of an observation; pictures end with ``_image``, and no key holds a slash."""
        plain = stream.replace("/", "_")
        return f"{plain}_image" if stream == episodes.camera else plain

    def remarks(self, episodes: Episodes) -> list[str]:
        """Return which parts have another name there."""
        renamed = [f"The part {part} is the filter key {key}." for part, key in FILTER_KEYS.items()]
        return renamed if "val" in episodes.part_ranges() else []

    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines that read the first part."""
        part = FILTER_KEYS.get(episodes.parts[0], episodes.parts[0])
        low = [self.kept_as(stream.name, episodes) for stream in episodes.streams]
        rgb = [self.kept_as(episodes.camera, episodes)]
        keys = ["actions"] if episodes.action is not None else []
        return "\n".join(
            [
                "import robomimic.utils.obs_utils as obs_utils",
                "from robomimic.utils.dataset import SequenceDataset",
                "",
                f"low_dim, rgb = {low!r}, {rgb!r}",
                'obs_utils.initialize_obs_utils_with_obs_specs({"obs": {"low_dim": low_dim, "rgb": rgb}})',
                f"keys = {[*keys, 'dones']!r}",
                f'dataset = SequenceDataset("{FILE}", low_dim + rgb, keys, filter_by_attribute="{part}")',
                'print(len(dataset), {key: value.shape for key, value in dataset[0]["obs"].items()})',
            ]
        )


def _add_next(demo: h5py.Group) -> None:
    """Add the next observations: views into the observations one frame later, the last one twice, without a copy."""
    for name, made in list(demo["obs"].items()):
        count = made.shape[0]
        parts = [(slice(0, count - 1), slice(1, count)), (slice(count - 1, count), slice(count - 1, count))]
        settings = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        # else HDF5 notes when the view was made, and equal exports differ
        settings.set_obj_track_times(False)
        for here, there in parts[0 if count > 1 else 1 :]:
            settings.set_virtual(_rows(made.shape, here), SAME_FILE, made.name.encode(), _rows(made.shape, there))
        space = h5py.h5s.create_simple(made.shape)
        h5py.h5d.create(demo.require_group("next_obs").id, name.encode(), made.id.get_type(), space, settings)


def _rows(shape: tuple[int, ...], rows: slice) -> h5py.h5s.SpaceID:
    """Return the place of some rows of an array, as HDF5 describes it."""
    space = h5py.h5s.create_simple(shape)
    space.select_hyperslab((rows.start, *[0] * (len(shape) - 1)), (rows.stop - rows.start, *shape[1:]))
    return space
