"""HDF5 files of one's own, read by a mapping (docs/formats-hdf5.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import ImageSink, Recording, Source
from tactiledata.contract.wording import listed
from tactiledata.errors import BrokenLog, SchemaError, UnsafeContent
from tactiledata.formats.base import Inspection, TopicInfo
from tactiledata.formats.hdf5.arrays import FoundArray, arrays_of, paths_read, streams_of
from tactiledata.formats.hdf5.draft import draft_mapping
from tactiledata.formats.hdf5.pictures import mapped_cameras, push_pictures
from tactiledata.formats.hdf5.signals import ArrayFile, read_signal
from tactiledata.formats.reading.corpus import CorpusFormat
from tactiledata.formats.reading.described import described_trajectories
from tactiledata.formats.reading.hdf5_members import HDF5_FAULTS, open_hdf5, reading_hdf5
from tactiledata.formats.reading.intake import Intake

SUFFIXES = (".h5", ".hdf5")
MAGIC = b"\x89HDF\r\n\x1a\n"
KEYS_OF_MESSAGES = {"signals": ("joint_names", "child_frame"), "images": ("data",)}
"""Keys of a mapping that are for recordings of messages alone."""
MOST_NAMED = 6
"""Arrays that a message names."""


class Hdf5Format(CorpusFormat):
    """A file of arrays with times beside them; a mapping says which array is what.

    A file is claimed where one of its arrays is called times (``time``, ``stamps``, ``t_ns``) and another one is as
    long. Nothing is read without a mapping: names of arrays say neither units nor signs.
    """

    name = "hdf5"
    title = "HDF5 file of your own"
    layout = """
<any>.h5|hdf5           arrays (n, 6), (n, 7), pictures (n, height, width, 3) or as JPEG files,
                        each with an array of n times; a mapping says which is what
"""

    def sniff(self, path: Path) -> bool:
        """Whether a file is HDF5 and holds an array with times beside it."""
        if path.suffix.lower() not in SUFFIXES or not path.is_file():
            return False
        try:
            if not _is_hdf5(path):
                return False
            with open_hdf5(path) as members:
                return bool(streams_of(arrays_of(members)))
        except UnsafeContent:  # ours to refuse, with the reason
            return True
        except HDF5_FAULTS:
            return False

    def sources(self, path: Path) -> Sequence[Source]:
        """The file is one recording; where this format is asked for, any HDF5 file: a mapping names its times."""
        if not (path.is_file() and _is_hdf5(path)):
            self.require(path)
        return [self.make_source(path, path, [path])]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The signals and pictures that a mapping names.

        Parameters
        ----------
        source : Source
            One HDF5 file, as `sources` found it.
        intake : Intake
            Takes pictures in the order of time; it is read afterwards for findings.
        mapping : dict, optional
            A mapping document.

        Raises
        ------
        BrokenLog
            There is no mapping, the file cannot be read as HDF5, or nothing that the mapping names is in it.
        NotFetched
            The file is a Git LFS pointer.
        UnsafeContent
            It takes values from another file.
        """
        path = Path(source.path)
        with _opened(path) as file:
            arrays = arrays_of(file.members)
            if not (mapping and (mapping.get("signals") or mapping.get("images"))):
                raise BrokenLog(
                    f"{path.name} holds arrays ({len(arrays)}) and does not say which is what",
                    "a mapping that names signals or images",
                    f"Begin with: tactiledata inspect {path.name} --suggest-mapping > mapping.yaml",
                    file=str(path),
                )
            _refuse_keys(mapping)
            entries = mapping.get("signals", {}).items()
            read = {name: read_signal(file, name, entry, intake) for name, entry in entries}
            signals = {name: signal for name, signal in read.items() if signal is not None}
            cameras = mapped_cameras(file, mapping, intake)
            self._note_rest(arrays, mapping, bool(cameras), intake)
            if not signals and not cameras:
                raise BrokenLog(
                    f"{path.name} has nothing of what the mapping names",
                    f"one of {listed([one.path for one in arrays], MOST_NAMED)}",
                    "Mend the paths: tactiledata inspect lists the arrays of a file.",
                    file=str(path),
                )
            push_pictures(cameras, intake)
        description = LogDescription({}, source.key)
        if mapping.get("description"):
            description = description.merged(mapping["description"], f"mapping for {source.key}")
        trajectories = described_trajectories(description)
        return self.finish(source, intake, description, trajectories, signals)

    def inspect(
        self, source: Source, mapping: Mapping[str, Any] | None = None, sink: ImageSink | None = None
    ) -> Inspection:
        """What the file holds, with a mapping to start from; what a mapping reads, where there is one.

        Parameters
        ----------
        source : Source
            One of `sources`.
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.
        sink : ImageSink, optional
            Takes the images in their order; those that were not opened come without bytes.
        """
        with _opened(Path(source.path)) as file:
            arrays = arrays_of(file.members)
        draft = draft_mapping(arrays)
        if mapping:
            inspection = super().inspect(source, mapping, sink)
            return replace(inspection, suggested_mapping=draft.document, suggested_text=draft.text)
        times = {one.path: time for one, time in streams_of(arrays)}
        topics = []
        for one in arrays:
            note = f"times in {times[one.path].path}" if one.path in times else ""
            note = "times" if one.is_time else note
            if one.dtype == "uint8" and len(one.shape) == 3:
                note = "pictures in grey are not read: (n, height, width, 3) are"
            shape = " x ".join(str(size) for size in one.shape) or "one value"
            topics.append(TopicInfo(one.path, f"{one.dtype}, {shape}", "hdf5", one.rows, note=note))
        facts = {"arrays": len(arrays), "to read it": "needs a mapping: --suggest-mapping drafts one"}
        return Inspection(source, tuple(topics), (), facts, suggested_mapping=draft.document, suggested_text=draft.text)

    def draft(
        self, inspections: Sequence[Inspection], mapping: Mapping[str, Any] | None = None
    ) -> tuple[Mapping[str, Any] | None, str]:
        """The draft of the first recording; the others are named where they have other arrays.

        Parameters
        ----------
        inspections : sequence of Inspection
            Made by `inspect`.
        mapping : dict, optional
            The mapping by which they were made.
        """
        first, *rest = inspections
        others = [one.source.key for one in rest if one.suggested_mapping != first.suggested_mapping]
        text = first.suggested_text
        if others:
            text = (
                f"# By {first.source.key}. Other arrays have {listed(others, MOST_NAMED)}:\n"
                f"# draft a mapping for each kind alone.\n{text}"
            )
        return first.suggested_mapping, text

    def _note_rest(
        self, arrays: Sequence[FoundArray], mapping: Mapping[str, Any], has_cameras: bool, intake: Intake
    ) -> None:
        """Say which arrays are not read, and where no camera of the mapping is in a file that has pictures."""
        pictures = [one.path for one in arrays if one.kind in ("pictures", "packed pictures")]
        if mapping.get("images") and pictures and not has_cameras:
            text = f"no camera of the mapping is in this file, so that {listed(pictures, MOST_NAMED)} is not kept"
            intake.note("pictures-not-mapped", "damage", text, count=len(pictures))
        read = paths_read(mapping)
        unread = [one.path for one in arrays if one.path not in read]
        if unread:
            text = f"arrays that no entry of the mapping names are not read: {listed(unread, MOST_NAMED)}"
            intake.note("topics-not-read", "info", text, count=len(unread))


def _is_hdf5(path: Path) -> bool:
    """Whether a file begins as an HDF5 file does."""
    with path.open("rb") as stream:
        return stream.read(len(MAGIC)) == MAGIC


def _refuse_keys(mapping: Mapping[str, Any]) -> None:
    """Refuse keys of a mapping that say nothing of arrays: left unread, they would mislead."""
    for section, keys in KEYS_OF_MESSAGES.items():
        for name, entry in mapping.get(section, {}).items():
            if found := [key for key in keys if key in entry]:
                raise SchemaError(
                    f"the mapping's {section}.{name} has {found[0]}, which is for messages, not for arrays",
                    "topic, time, time_unit, and fields, units, rotation, frame or sensor, channel_order",
                    "Write a mapping of its own for HDF5 files.",
                    path=f"$.{section}.{name}.{found[0]}",
                )


@contextmanager
def _opened(path: Path) -> Iterator[ArrayFile]:
    """Open a file whose arrays are read by their paths."""
    remedy = "Copy the file again; a file whose writer was killed may open after h5clear -s."
    with reading_hdf5(path, "a whole HDF5 file", remedy) as members:
        yield ArrayFile(members, path.name)
