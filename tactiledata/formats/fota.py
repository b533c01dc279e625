"""T3's Foundation Tactile set (FoTa): WebDataset tars of JPEG and JSON pairs, one folder a domain."""

from __future__ import annotations

import json
import re
import tarfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    Timeline,
    describe,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    stream_name,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_key, natural_paths
from tactiledata.units import SIGNAL_COLUMNS

TAR_NAME = re.compile(r"data-\d+\.tar")
PARTS = ("train", "val")
IMAGES = ("jpg", "jpeg", "png")
MAX_LABEL_BYTES = 2**20
MAX_TEXTS = 20
"""Different texts of one label that a trajectory keeps."""
POSE = {
    "x_mm": 1e-3, "y_mm": 1e-3, "z_mm": 1e-3, "quat_x": 1.0, "quat_y": 1.0, "quat_z": 1.0, "quat_w": 1.0,
}  # fmt: skip
POSITION = ("x_mm", "y_mm", "z_mm")
"""All that domains with a pose of three numbers state; T3's loader reads no more of them."""
SEQUENCES = {
    "tvl": re.compile(r"(data\d+|ssvtp)"),
    "calandra17": re.compile(r"(.*_\d+)_gelsight[AB]_(?:during|before)"),
}
"""Domains whose keys do not end in a frame number: what of a key names the sequence. TVL's keys have lost the folder
that told its sequences apart, so each of its parts is one sequence: coarse, but it cannot leak."""
FRAME_NUMBER = re.compile(r"[-_]?(?:frame)?[-_]?\d+$")
MODELS = {"tvl": "digit", "calandra17": "gelsight", "visgel": "gelsight", "yuan18": "gelsight"}


@dataclass(slots=True)
class _Sample:
    """The places of the two files of one sample in a tar: (tar, first byte, bytes)."""

    key: str
    part: str
    image: tuple[Path, int, int] | None = None
    label: tuple[Path, int, int] | None = None


@dataclass
class _Sequence:
    samples: list[_Sample] = field(default_factory=list)
    texts: dict[str, list[str]] = field(default_factory=dict)


def sequence_of(key: str, domain: str) -> str:
    """The sequence that a sample belongs to: its key without the frame's number.

    Examples
    --------
    >>> sequence_of("3_2_frame000017", "yuan18"), sequence_of("data1_165-0-0172", "tvl")
    ('3_2', 'data1')
    """
    pattern = next((found for name, found in SEQUENCES.items() if domain.startswith(name)), None)
    match = pattern.match(key) if pattern else None
    return (match.group(1) if match else FRAME_NUMBER.sub("", key)) or key


class FotaFormat(CorpusFormat):
    """FoTa: one source per domain, train and val together, frames put back into the sequences they came from."""

    name = "fota"
    title = "T3 Foundation Tactile (FoTa)"
    layout = "<domain>/{train,val}/{data-<nnnnnn>.tar of <key>.jpg and <key>.json, count.txt}"
    licence_note = "A collection: the licence of each original data set applies; T3's code is MIT."

    def sniff(self, path: Path) -> bool:
        """Whether tars named ``data-000000.tar`` with images and JSON lie here or below."""
        if path.is_file():
            return bool(TAR_NAME.fullmatch(path.name)) and _looks_right(path)
        return path.is_dir() and any(_looks_right(tars[0]) for _, tars in _domains(path))

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per domain, or the one tar that was named."""
        self.require(path)
        if path.is_file():
            return [Source(str(path), path.name, self.name, (str(path),))]
        return [
            self.make_source(path, domain, [*tars, *(count for count in _counts(domain) if count.is_file())])
            for domain, tars in _domains(path)
        ]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """A domain: sequences one after another, the published part of each image kept as a value.

        Parameters
        ----------
        source : Source
            A folder of tars, or one tar, as `sources` found it.
        intake : Intake
            Takes the images and the published part of each; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        path = Path(source.path)
        domain = (path.parent if path.is_file() else path).resolve().name
        tars = [path] if path.is_file() else dict(_domains(path)).get(path, [])
        samples = _index(tars, intake)
        if not any(sample.image for sample in samples):
            raise_empty(source, "tars of JPEG and JSON pairs")
        if path.is_dir():
            _check_counts(path, samples, intake)
        sequences = _regrouped(samples, domain, intake)
        sensor = sensor_for("tactile", f"fota-{domain}", mapping)
        note_nominal_rate(intake, "the corpus")
        intake.declare("published_part", ("part",), ("1",), "0 train, 1 val, as published: that split shuffles frames")
        timeline, touches = Timeline(), []
        for name, sequence in sequences.items():
            timeline.begin()
            for index, sample in enumerate(sequence.samples):
                _push(sample, sequence, timeline.at(index), sensor, name, intake)
            extra = {what: texts[0] if len(texts) == 1 else json.dumps(texts) for what, texts in sequence.texts.items()}
            touches.append(Trajectory(name, *timeline.interval(), sensor, "", {"domain": domain, **extra}))
        model = "digit" if "digit" in domain.lower() else MODELS.get(domain.removesuffix("_downsampled"), "unknown")
        description = describe(source, mapping, {sensor: model}, f"FoTa {domain}", self.licence_note)
        return self.finish(source, intake, description, touches)


def _domains(path: Path) -> Iterator[tuple[Path, list[Path]]]:
    """Folders with train/ and val/ (or with tars themselves, where such a part was named), and their tars."""
    for folder in subfolders(path, 3):
        if folder.name in PARTS and folder != path:
            continue
        tars = [tar for part in PARTS for tar in _tars(folder / part)] or _tars(folder)
        if tars:
            yield folder, tars


def _tars(folder: Path) -> list[Path]:
    if not folder.is_dir() or folder.is_symlink():
        return []
    return natural_paths(path for path in folder.iterdir() if TAR_NAME.fullmatch(path.name) and path.is_file())


def _counts(domain: Path) -> list[Path]:
    return [domain / "count.txt", *(domain / part / "count.txt" for part in PARTS)]


def _looks_right(tar: Path) -> bool:
    """Whether the first members are an image and a JSON of one key, or the tar is damaged before that shows."""
    suffixes: set[str] = set()
    try:
        with tarfile.open(tar, "r:") as archive:
            for _ in range(4):
                member = archive.next()
                if member is None:
                    break
                suffixes.add(PurePosixPath(member.name).suffix.lstrip(".").lower())
    except (tarfile.TarError, OSError, ValueError):
        return True
    return not suffixes or (suffixes <= {*IMAGES, "json"} and bool(suffixes & set(IMAGES)))


def _index(tars: Sequence[Path], intake: Intake) -> list[_Sample]:
    """Return the places of all samples; a tar that is cut gives the samples before the cut."""
    samples: dict[tuple[str, str, int], _Sample] = {}
    for tar in tars:
        seen: dict[tuple[str, str], int] = {}
        part = tar.parent.name if tar.parent.name in PARTS else ""
        for member, start, size in _members(tar, intake):
            key, _, suffix = PurePosixPath(member).name.partition(".")
            suffix = suffix.lower()
            if suffix not in (*IMAGES, "json"):
                intake.note("not-read", "info", f"{member} is neither image nor JSON", tar.name)
                continue
            kind = "json" if suffix == "json" else "image"
            turn = seen.get((key, kind), 0)
            seen[key, kind] = turn + 1
            place = (str(tar), key, turn)
            sample = samples.setdefault(place, _Sample(key, part))
            if kind == "json":
                sample.label = (tar, start, size)
            else:
                sample.image = (tar, start, size)
    return list(samples.values())


def _members(tar: Path, intake: Intake) -> Iterator[tuple[str, int, int]]:
    """Name, first byte and size of the plain files of a tar; nothing is ever extracted."""
    refuse_lfs_pointer(tar)
    whole = tar.stat().st_size
    try:
        with tarfile.open(tar, "r:") as archive:
            while (member := archive.next()) is not None:
                archive.members = []  # type: ignore[attr-defined]  # the library would keep every member that it has seen
                _check_name(tar, member.name)
                if member.isdir():
                    continue
                if not member.isreg():
                    intake.note("tar-member-odd", "damage", f"{member.name} in {tar.name} is no plain file", tar.name)
                    continue
                if member.offset_data + member.size > whole:
                    raise tarfile.ReadError(f"{member.name} reaches beyond the end")
                yield member.name, member.offset_data, member.size
    except UnsafeContent:  # it is a ValueError, and no damage
        raise
    except (tarfile.TarError, EOFError, ValueError, OverflowError) as error:
        intake.note("tar-truncated", "damage", f"{tar.name} is cut or damaged: {error}", tar.name)


def _check_name(tar: Path, name: str) -> None:
    try:
        path_inside(tar.parent, name, f"{tar}")
    except UnsafeContent as error:
        raise UnsafeContent(
            f"{tar} has a member named {name!r}, which leads out of the archive",
            "names below the archive",
            "Do not unpack it; fetch it again from its origin.",
            path=name,
            file=str(tar),
        ) from error


def _check_counts(domain: Path, samples: Sequence[_Sample], intake: Intake) -> None:
    for path in _counts(domain):
        if not path.is_file():
            if path.parent != domain and path.parent.is_dir():
                intake.note("count-missing", "warning", f"{path.parent.name}/count.txt is not there", path.parent.name)
            continue
        text = path.read_bytes()[:64].decode("ascii", "replace").strip()
        part = path.parent.name if path.parent != domain else ""
        here = sum(1 for sample in samples if sample.image and (not part or sample.part == part))
        if not text.isdigit() or int(text) != here:
            lacks = not text.isdigit() or int(text) > here
            found = f"{path.parent.name}/count.txt says {text[:20]!r}, {here} images are there"
            if lacks:
                intake.note("count-mismatch", "damage", found, path.parent.name)
            else:
                intake.note("count-exceeded", "warning", found, path.parent.name)


def _regrouped(samples: Sequence[_Sample], domain: str, intake: Intake) -> dict[str, _Sequence]:
    """Samples in the sequences that their keys name, in natural order: the published split parted them."""
    sequences: dict[str, _Sequence] = {}
    for sample in samples:
        sequences.setdefault(sequence_of(sample.key, domain), _Sequence()).samples.append(sample)
    torn, keys, repeated = 0, set(), 0
    for sequence in sequences.values():
        sequence.samples.sort(key=lambda sample: (natural_key(sample.key), sample.part))
        torn += len({sample.part for sample in sequence.samples}) > 1
        for sample in sequence.samples:
            repeated += sample.key in keys
            keys.add(sample.key)
    if torn:
        found = (
            f"the published split has frames of {torn} of {len(sequences)} sequences on both sides; put together again"
        )
        intake.note("published-split-leaks", "warning", found, count=torn)
    if repeated:
        intake.note("duplicate-key", "warning", f"{repeated} keys are given twice; all are kept", count=repeated)
    alone = sum(len(sequence.samples) == 1 for sequence in sequences.values())
    if len(samples) > 4 and alone > len(sequences) / 2:
        found = f"{alone} of {len(sequences)} sequences hold one image: the keys may not tell sequences apart"
        intake.note("sequence-unclear", "warning", found)
    return dict(sorted(sequences.items(), key=lambda pair: natural_key(pair[0])))


def _push(sample: _Sample, sequence: _Sequence, t_ns: int, sensor: str, name: str, intake: Intake) -> None:
    values: dict[str, Any] = {"published_part": [float(PARTS.index(sample.part))]} if sample.part else {}
    if sample.label is None:
        intake.note("image-without-json", "warning", f"{sample.key} has no JSON", "tactile")
    else:
        values |= _labels(sample, sequence, intake)
    if sample.image is None:
        found = f"{sample.key}.json has no image beside it; its moment is kept without one"
        intake.note("json-without-image", "damage", found, "tactile")
    payload = None if sample.image is None else partial(_read, *sample.image)
    intake.image("tactile", payload, t_ns, sensor=sensor, trajectory=name, name=sample.key, values=values)


def _read(tar: Path, start: int, size: int) -> bytes:
    with tar.open("rb") as stream:
        stream.seek(start)
        return stream.read(size)


def _labels(sample: _Sample, sequence: _Sequence, intake: Intake) -> dict[str, list[float]]:
    """The numbers of a JSON by name, its pose in metres; texts are kept with the sequence."""
    assert sample.label is not None
    tar, start, size = sample.label
    try:
        if size > MAX_LABEL_BYTES:
            raise BrokenLog(f"{size} bytes of JSON")
        content = json.loads(_read(tar, start, size))
        if not isinstance(content, dict):
            raise BrokenLog(f"a {type(content).__name__}")
    except (ValueError, RecursionError) as error:
        intake.note("label-broken", "damage", f"{sample.key}.json cannot be read: {str(error)[:100]}", "tactile")
        return {}
    values: dict[str, list[float]] = {}
    if set(POSE) <= set(content) and all(isinstance(content[key], int | float) for key in POSE):
        units = ("m", "m", "m", "1", "1", "1", "1")
        intake.declare("pose", SIGNAL_COLUMNS["tcp"], units, "as the corpus gives it, millimetres turned into metres")
        values["pose"] = [float(content.pop(key)) * scale for key, scale in POSE.items()]
    elif set(POSITION) <= set(content) and all(isinstance(content[key], int | float) for key in POSITION):
        intake.declare(
            "position", ("x", "y", "z"), ("m", "m", "m"), "as the corpus gives it, millimetres turned into metres"
        )
        values["position"] = [float(content.pop(key)) * POSE[key] for key in POSITION]
    for key, value in content.items():
        kept = stream_name(f"label_{key}")
        if isinstance(value, bool | int | float) and np.isfinite(float(value)):
            intake.declare(kept, (kept,), ("?",), f"{key!r} of the JSON")
            values[kept] = [float(value)]
        elif isinstance(value, str):
            texts = sequence.texts.setdefault(kept, [])
            if value not in texts and len(texts) < MAX_TEXTS:
                texts.append(value[:2000])
        elif value is not None:
            intake.note("not-read", "info", f"label {key!r} is no number and no text", "tactile")
    return values
