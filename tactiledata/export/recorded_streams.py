"""What a store holds of each recording: rows of its signals, rows of its frames, what it said of itself."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.arrays import Times
from tactiledata.contract.description import LOG_FORMAT, LogDescription
from tactiledata.contract.schema import load_schema
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import SchemaError
from tactiledata.store.layout.places import folder_name
from tactiledata.store.read.reader import Store

TEXTS = ("camera", "sensor", "encoding")
FRAME_COLUMNS = (*TEXTS, "source", "t_ns", "log_ns", "publish_ns", "header_ns", "height", "width", "flags")


@dataclass(frozen=True)
class RecordedStamps:
    """Stamps of n messages, (n,) int64 ns each, as a log with three clocks has them.

    Parameters
    ----------
    log_ns, publish_ns : (n,) int64
        When a message was recorded and sent.
    header_ns : (n,) int64
        What the message itself says; 0 where it says nothing.
    """

    log_ns: NDArray[np.int64]
    publish_ns: NDArray[np.int64]
    header_ns: NDArray[np.int64]

    @classmethod
    def of(cls, t_ns: Times, log_ns: Times, publish_ns: Times, header_ns: Times) -> RecordedStamps:
        """Return the stamps of a stream whose recording had three clocks, or one.

        One clock is that of the stream: it becomes the header's, to which a stated offset applies, and the log time is
        the host's.

        Parameters
        ----------
        t_ns : (n,) int64
            Host clock.
        log_ns, publish_ns, header_ns : (n,) int64
            As recorded; -1 where there is none.
        """
        if len(t_ns) and (publish_ns < 0).all() and (header_ns < 0).all():
            return cls(t_ns, t_ns, np.maximum(log_ns, 0))
        return cls(log_ns, np.where(publish_ns < 0, log_ns, publish_ns), np.maximum(header_ns, 0))

    def ordered(self) -> tuple[NDArray[np.intp], RecordedStamps]:
        """Return the order of the log times, and the stamps in it."""
        order = np.argsort(self.log_ns, kind="stable")
        return order, RecordedStamps(self.log_ns[order], self.publish_ns[order], self.header_ns[order])


@dataclass(frozen=True)
class RecordedFrames:
    """The images of one camera in one recording, in the order of their log times.

    Parameters
    ----------
    rows : (n,) int64
        Rows in the store.
    stamps : RecordedStamps
    sensors : list of n str
    sizes : (n, 2) int64
        Height and width.
    encodings : list of n str
        ``jpeg``, ``png`` or ``raw``.
    """

    rows: NDArray[np.int64]
    stamps: RecordedStamps
    sensors: list[str]
    sizes: NDArray[np.int64]
    encodings: list[str]

    @property
    def are_raw(self) -> bool:
        """Whether all of them are kept as pixels."""
        return all(encoding == "raw" for encoding in self.encodings)


class RecordedStreams:
    """The recordings of a store, by their rows in the table of sources."""

    def __init__(self, store: Store) -> None:
        self._store = store

    @cached_property
    def sources(self) -> list[dict[str, Any]]:
        """Facts of every recording: key, digest, description, and the rows of its signals."""
        columns = ["sha256", "key", "format", "status", "description", "contents"]
        return self._store.sources(columns).to_pylist()

    @cached_property
    def _frames(self) -> dict[str, NDArray[Any]]:
        """Columns of all frames; texts as codes."""
        table = self._store.frames(list(FRAME_COLUMNS)).combine_chunks()
        columns: dict[str, NDArray[Any]] = {}
        for name in FRAME_COLUMNS:
            if name in TEXTS:
                texts = table[name].cast(pa.string()).combine_chunks().dictionary_encode()
                columns[name] = np.asarray(texts.indices)
                columns[f"{name}s"] = np.array(texts.dictionary.to_pylist(), object)
            else:
                columns[name] = table[name].to_numpy()
        return columns

    @cached_property
    def _places(self) -> dict[int, tuple[int, int]]:
        """First frame and number of frames of each recording; they are side by side."""
        sources, first, counts = np.unique(self._frames["source"], return_index=True, return_counts=True)
        return {
            int(source): (int(start), int(count)) for source, start, count in zip(sources, first, counts, strict=True)
        }

    @cached_property
    def frame_counts(self) -> NDArray[np.int64]:
        """Number of frames (n_sources,) with an image in each recording."""
        has_image = (self._frames["flags"] & FrameFlag.MISSING) == 0
        return np.bincount(self._frames["source"][has_image], minlength=len(self.sources))

    @cached_property
    def file_names(self) -> list[str]:
        """A file name, without suffix, for every recording: that of its key, and its digest where several share it."""
        stems = [folder_name(PurePosixPath(source["key"]).with_suffix("").as_posix()) for source in self.sources]
        return [
            f"{stem}-{source['sha256'][:8]}" if stems.count(stem) > 1 else stem
            for stem, source in zip(stems, self.sources, strict=True)
        ]

    def signals(self, source: int) -> dict[str, tuple[str, int, int]]:
        """Return name in the store and rows [start, stop) of each signal of a recording, by the recording's name."""
        contents = json.loads(self.sources[source]["contents"])["signals"]
        return {facts["name"]: (stored, *map(int, facts["rows"])) for stored, facts in sorted(contents.items())}

    def frames(self, source: int) -> dict[str, RecordedFrames]:
        """Return the images of each camera of a recording; captured moments without an image are left out."""
        columns = self._frames
        first, count = self._places.get(source, (0, 0))
        mine = np.arange(first, first + count)
        mine = mine[(columns["flags"][mine] & FrameFlag.MISSING) == 0]
        found = {}
        for code in np.unique(columns["camera"][mine]).tolist():
            rows = mine[columns["camera"][mine] == code]
            times = (columns[name][rows] for name in ("t_ns", "log_ns", "publish_ns", "header_ns"))
            order, stamps = RecordedStamps.of(*times).ordered()
            rows = rows[order]
            found[str(columns["cameras"][code])] = RecordedFrames(
                rows,
                stamps,
                [name or "" for name in columns["sensors"][columns["sensor"][rows]].tolist()],
                np.stack([columns["height"][rows], columns["width"][rows]], axis=1).astype(np.int64),
                columns["encodings"][columns["encoding"][rows]].tolist(),
            )
        return found

    @cached_property
    def _trajectories(self) -> dict[int, list[dict[str, Any]]]:
        """Trajectories of each recording."""
        by_source: dict[int, list[dict[str, Any]]] = {}
        names = [
            "source",
            "uid",
            "trajectory",
            "sensor",
            "indenter",
            "start_ns",
            "end_ns",
            "segmented",
            "parent",
            "extra",
        ]
        for row, facts in enumerate(self._store.trajectories(names).to_pylist()):
            by_source.setdefault(facts["source"], []).append({"row": row, **facts})
        return by_source

    def trajectories(self, source: int) -> list[dict[str, Any]]:
        """Return the trajectories of a recording, each with its row in the store's table."""
        return self._trajectories.get(source, [])

    def description(self, source: int) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        """Return the description of a recording as a log carries it, and what of it no log does.

        The first has the trajectories that the recording named, wherever it named them. It is empty where a reader of
        logs would refuse it, as where no sensor is known; the second is then all of it.
        """
        stated = dict(json.loads(self.sources[source]["description"] or "{}"))
        named = {facts["trajectory"]: facts for facts in self.trajectories(source) if facts["segmented"] == "log"}
        if named:
            # as the store has them: a transfer keeps the description, and its touches have another sensor
            before = [each for each in stated.get("trajectories", []) if each["trajectory"] not in named]
            stated["trajectories"] = [*before, *map(_described, named.values())]
        stated["sensors"] = self._sensors(stated.get("sensors", {}), self.trajectories(source))
        fields = load_schema("log")["properties"]
        others = {name: value for name, value in stated.items() if name not in fields}
        log = {**{name: value for name, value in stated.items() if name in fields}, "format": LOG_FORMAT}
        try:
            LogDescription.checked(log, self.sources[source]["key"])
        except SchemaError:
            return {}, stated
        return log, others

    def _sensors(self, stated: Mapping[str, Any], touches: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Return the sensors of a recording as a description states them, with those that only its touches name.

        Pictures without contact are named where the store holds them, and nowhere else.
        """
        held, known = self._store.manifest["references"], self._store.sensors()
        touched = sorted({touch["sensor"] for touch in touches} - {"", None, *stated})
        sensors = {**stated, **{name: {"model": known.get(name, {}).get("model") or "unknown"} for name in touched}}
        for name, facts in sensors.items():
            picture = {"background": facts.get("background", f"backgrounds/{folder_name(name)}.png")}
            others = {key: value for key, value in facts.items() if key != "background"}
            sensors[name] = {**others, **(picture if name in held else {})}
        return sensors


def _described(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return a trajectory as a description states it, its free columns among the others."""
    fixed = {name: facts[name] for name in ("trajectory", "start_ns", "end_ns")}
    fixed |= {name: facts[name] for name in ("sensor", "indenter") if facts[name]}
    return {**json.loads(facts["extra"] or "{}"), **fixed}
