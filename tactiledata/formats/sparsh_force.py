"""Sparsh force estimation: a DIGIT pressed by probes on a force sensor, images and forces in pickles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    describe,
    nominal_ns,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    stream_name,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake, Payload
from tactiledata.formats.reading.natural_order import natural_key, natural_paths
from tactiledata.formats.reading.pickled_list import BytesList, index_bytes_list
from tactiledata.formats.reading.restricted_pickle import load_pickle

FORCES = "dataset_slip_forces.pkl"
SENSORS = {"digit": "digit", "gelsight": "gelsight_mini"}
"""Name in the file names -> sensor model. The GelSight sibling of the corpus has the same layout."""
REFERENCE_FRAMES = 9
"""Images without contact, spread over a batch, whose median is the reference picture."""
KNOWN = {"indexes", "forces"}


@dataclass(frozen=True)
class _Images:
    """The batch's images as one list, whatever files they lie in."""

    parts: tuple[tuple[BytesList | list[Any], str], ...]

    def __len__(self) -> int:
        return sum(len(items) for items, _ in self.parts)

    def __iter__(self) -> Iterator[tuple[Payload | None, str]]:
        for items, name in self.parts:
            for row in range(len(items)):
                is_there = isinstance(items, BytesList) or items[row] is not None
                yield _payload(items, row) if is_there else None, f"{name}[{row}]"

    def at(self, index: int) -> Payload:
        for items, _ in self.parts:
            if index < len(items):
                return _payload(items, index)
            index -= len(items)
        raise IndexError(index)


def _payload(items: BytesList | list[Any], row: int) -> Payload:
    def load() -> bytes | NDArray[np.uint8]:
        item = items[row]
        return item if isinstance(item, bytes | np.ndarray) else b""

    return load


class SparshForceFormat(CorpusFormat):
    """Sparsh's force sets: one source per batch, trajectories as the corpus lists them, forces per image."""

    name = "sparsh_force"
    title = "Sparsh digit-force-estimation (DIGIT, forces)"
    layout = """{sphere,flat,sharp}/batch_<k>/{dataset_digit_<nn>.pkl (lists of JPEG bytes), dataset_slip_forces.pkl}"""
    licence_note = (
        "CC BY-NC 4.0 (facebook/digit-force-estimation): not for commercial use; cite Higuera et al., CoRL 2024."
    )

    def sniff(self, path: Path) -> bool:
        """Whether a folder with ``dataset_slip_forces.pkl`` lies here or below."""
        return path.is_dir() and next(_batches(path), None) is not None

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per batch."""
        self.require(path)
        return [self.make_source(path, batch, [*_image_files(batch)[1], batch / FORCES]) for batch in _batches(path)]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """Read a batch: its images in order, with forces and other values of each image, NaN where none was measured.

        Parameters
        ----------
        source : Source
            A folder of one batch, as `sources` found it.
        intake : Intake
            Takes the images with their values; it is read afterwards for findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        folder = Path(source.path)
        kind, files = _image_files(folder)
        labels = _labels(folder / FORCES)
        images = _open(files, np.size(labels["in_contact"]) if "in_contact" in labels else None, intake)
        if not len(images):
            raise_empty(source, "dataset_digit_<nn>.pkl with images")
        sensor = sensor_for(kind, f"sparsh-{kind}", mapping)
        probe = folder.resolve().parent.name
        in_contact = _contact(labels, len(images), intake)
        values, owner, extras = _values(labels, len(images), intake)
        if in_contact is not None:
            values["in_contact"] = in_contact[:, None]
        _declare(values, intake)
        note_nominal_rate(intake, "the corpus")
        names = list(extras)
        for index, (payload, name) in enumerate(images):
            row = {what: table[index] for what, table in values.items() if np.isfinite(table[index]).any()}
            touch = names[owner[index]] if owner[index] >= 0 else ""
            intake.image(kind, payload, nominal_ns(index), sensor=sensor, trajectory=touch, name=name, values=row)
        touches = _trajectories(owner, extras, sensor, probe, intake)
        description = describe(
            source, mapping, {sensor: SENSORS[kind]}, "Sparsh force estimation", "see the data set's card"
        )
        references = _reference(images, in_contact, sensor)
        return self.finish(source, intake, description, touches, references=references)


def _batches(path: Path) -> Iterator[Path]:
    for folder in subfolders(path, 3):
        if (folder / FORCES).is_file():
            yield folder


def _image_files(folder: Path) -> tuple[str, list[Path]]:
    for kind in SENSORS:
        files = [path for path in folder.glob(f"dataset_{kind}_*.pkl") if path.is_file() and not path.is_symlink()]
        if files:
            return kind, natural_paths(files)
    return "digit", []


def _open(files: Sequence[Path], expected: int | None, intake: Intake) -> _Images:
    """The lists of images, indexed; a list of arrays is loaded whole, under the same restrictions.

    A file that is cut leaves moments without images, so that the indexes behind it still fit (``expected`` images).
    """
    parts: list[tuple[BytesList | list[Any], str]] = []
    cut: list[int] = []
    for path in files:
        indexed = index_bytes_list(path)
        loaded = load_pickle(path) if indexed is None else indexed
        if not isinstance(loaded, BytesList | list | tuple):
            raise _misshapen(path, f"a {type(loaded).__name__}", "a list of images")
        parts.append((list(loaded) if isinstance(loaded, tuple) else loaded, path.name))
        if isinstance(loaded, BytesList) and not loaded.complete:
            cut.append(len(parts))
            found = f"{path.name} is cut after {len(loaded)} images; the later ones are lost"
            intake.note("pickle-truncated", "damage", found, path.name)
    lost = (expected or 0) - sum(len(items) for items, _ in parts)
    if cut and lost > 0 and len(cut) == 1:
        parts.insert(cut[0], ([None] * lost, f"behind the cut in {files[cut[0] - 1].name}"))
    elif cut and cut != [len(parts)]:
        raise BrokenLog(
            f"{len(cut)} files of images are cut: which image has which number cannot be known",
            "whole files, or one cut file and a flag of contact for every image",
            "Fetch the cut files again.",
        )
    return _Images(tuple(parts))


def _labels(path: Path) -> Mapping[str, Any]:
    content = load_pickle(path)
    if not isinstance(content, dict) or not isinstance(content.get("trajectories"), dict | list | tuple):
        raise _misshapen(path, f"a {type(content).__name__} without trajectories", "a dict {in_contact, trajectories}")
    return content


def _contact(labels: Mapping[str, Any], count: int, intake: Intake) -> NDArray[np.float64] | None:
    if "in_contact" not in labels:
        intake.note("contact-missing", "warning", "in_contact is not in the file: contact is not known image by image")
        return None
    given = _matrix(labels["in_contact"]).reshape(-1)
    if len(given) != count:
        found = f"{len(given)} contact flags for {count} images: the numbering of images cannot be trusted"
        intake.note("count-mismatch", "damage", found, count=abs(len(given) - count))
    whole = np.full(count, np.nan)
    whole[: min(count, len(given))] = given[:count]
    return whole


def _values(
    labels: Mapping[str, Any], count: int, intake: Intake
) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.int64], dict[str, dict[str, Any]]]:
    """Tables (count, k) of what trajectories give image by image, whose image is whose, what they say of themselves.

    Pairing is done inside each trajectory: some list a few more indexes than forces; joined lists would drift apart.
    """
    tables: dict[str, NDArray[np.float64]] = {"force": np.full((count, 3), np.nan)}
    owner = np.full(count, -1, dtype=np.int64)
    extras: dict[str, dict[str, Any]] = {}
    for number, (key, content) in enumerate(_listed(labels["trajectories"])):
        name = f"trajectory_{key}"
        extras[name] = {}
        rows, forces = _indexes(content), _matrix(content.get("forces", np.zeros((0, 3))))
        if forces.shape[1:] != (3,):
            raise _misshapen(Path(FORCES), f"forces of shape {forces.shape} in trajectory {key}", "rows of Fx, Fy, Fz")
        _pair(rows, forces, "force", name, tables, intake)
        inside = rows[(rows >= 0) & (rows < count)]
        if (owner[inside] >= 0).any():
            shared = int((owner[inside] >= 0).sum())
            intake.note("trajectory-overlap", "damage", "images are listed by two trajectories", count=shared)
        owner[inside[owner[inside] < 0]] = number
        for what, given in content.items():
            if what not in KNOWN:
                _other(str(what), given, rows, name, tables, extras[name], intake)
    return tables, owner, extras


def _listed(trajectories: Any) -> list[tuple[Any, Mapping[str, Any]]]:
    pairs = list(trajectories.items()) if isinstance(trajectories, dict) else list(enumerate(trajectories))
    for key, content in pairs:
        if not isinstance(content, dict) or "indexes" not in content:
            raise _misshapen(Path(FORCES), f"trajectory {key} without indexes", "a dict {indexes, forces, slip_label}")
    return sorted(pairs, key=lambda pair: natural_key(str(pair[0])))


def _indexes(content: Mapping[str, Any]) -> NDArray[np.int64]:
    given = np.asarray(content["indexes"]).reshape(-1)
    if given.dtype.kind not in "iu" and not (given.dtype.kind == "f" and np.isfinite(given).all()):
        raise _misshapen(Path(FORCES), f"indexes of type {given.dtype}", "whole numbers")
    return given.astype(np.int64)


def _matrix(given: Any) -> NDArray[np.float64]:
    try:
        table = np.asarray(given, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise _misshapen(Path(FORCES), f"values that are not numbers ({error})", "arrays of numbers") from error
    return table[:, None] if table.ndim == 1 else table


def _pair(
    rows: NDArray[np.int64],
    table: NDArray[np.float64],
    what: str,
    name: str,
    tables: dict[str, NDArray[np.float64]],
    intake: Intake,
) -> None:
    """The first values go with the first indexes; what is left over on either side is reported."""
    if len(rows) != len(table):
        found = f"{name}: {len(rows)} indexes and {len(table)} values of {what}; paired from the first on"
        intake.note("values-unpaired", "warning", found, what, name, count=abs(len(rows) - len(table)))
    paired = min(len(rows), len(table))
    rows, table = rows[:paired], table[:paired]
    is_inside = (rows >= 0) & (rows < len(tables[what]))
    if not is_inside.all():
        found = f"{name}: {int((~is_inside).sum())} indexes point at no image"
        intake.note("index-outside", "damage", found, what, name, count=int((~is_inside).sum()))
    tables[what][rows[is_inside]] = table[is_inside]


def _other(
    what: str,
    given: Any,
    rows: NDArray[np.int64],
    name: str,
    tables: dict[str, NDArray[np.float64]],
    extra: dict[str, Any],
    intake: Intake,
) -> None:
    """Slip labels and whatever else a trajectory holds: per image where it has that length, else said once."""
    if isinstance(given, str | bool | int | float | np.generic):
        extra[what] = given.item() if isinstance(given, np.generic) else given
        return
    try:
        table = _matrix(given)
    except BrokenLog:
        table = np.zeros((0, 0))
    kept = stream_name("slip" if what == "slip_label" else what)
    is_shaped = table.ndim == 2 and len(table) >= min(len(rows), 2) and 0 < table.shape[1] <= 64
    if kept in tables:
        is_shaped &= tables[kept].shape[1:] == table.shape[1:]
    if not is_shaped:
        intake.note("not-read", "info", f"{what} of {name} is no table of values per image", what)
        return
    tables.setdefault(kept, np.full((len(tables["force"]), table.shape[1]), np.nan))
    _pair(rows, table, kept, name, tables, intake)


def _declare(tables: Mapping[str, NDArray[np.float64]], intake: Intake) -> None:
    for what, table in tables.items():
        if what == "force":
            note = "x and y shear, z normal, as the corpus gives them; NaN outside the listed contacts"
            intake.declare("force", ("fx", "fy", "fz"), ("N", "N", "N"), note)
        else:
            width = table.shape[1]
            columns = (what,) if width == 1 else tuple(f"{what}_{column}" for column in range(width))
            unit = "1" if what in ("in_contact", "slip") else "?"
            intake.declare(what, columns, (unit,) * width, "as the corpus gives it")


def _trajectories(
    owner: NDArray[np.int64], extras: Mapping[str, dict[str, Any]], sensor: str, probe: str, intake: Intake
) -> list[Trajectory]:
    """Intervals that cover each trajectory's images; where one reaches into the next it ends there."""
    touches = []
    for number, (name, extra) in enumerate(extras.items()):
        rows = np.flatnonzero(owner == number)
        if not len(rows):
            intake.note("trajectory-empty", "warning", f"{name} has no image", trajectory=name)
            continue
        end = nominal_ns(int(rows[-1]) + 1)
        touches.append(Trajectory(name, nominal_ns(int(rows[0])), end, sensor, probe, {"probe": probe, **extra}))
    touches.sort(key=lambda touch: touch.start_ns)
    parted = []
    for touch, following in zip_longest(touches, touches[1:]):
        if following is not None and touch.end_ns > following.start_ns:
            found = f"{touch.name} reaches into {following.name} and is ended where that begins"
            intake.note("trajectory-overlap", "damage", found, trajectory=touch.name)
            touch = replace(touch, end_ns=following.start_ns)
        parted.append(touch)
    return parted


def _reference(
    images: _Images, in_contact: NDArray[np.float64] | None, sensor: str
) -> dict[str, tuple[NDArray[np.uint8], str]]:
    """The median of images without contact, spread over the batch."""
    if in_contact is None or not (in_contact == 0).any():
        return {}
    free = np.flatnonzero(in_contact == 0)
    pictures: list[NDArray[np.uint8]] = []
    for row in free[np.linspace(0, len(free) - 1, min(len(free), REFERENCE_FRAMES)).astype(int)]:
        try:
            content = images.at(int(row))()
            picture = content if isinstance(content, np.ndarray) else decode_rgb(content)
        except BrokenLog:
            continue
        if not pictures or picture.shape == pictures[0].shape:
            pictures.append(picture)
    if not pictures:
        return {}
    median = np.median(np.stack(pictures), axis=0).astype(np.uint8)
    return {sensor: (median, f"median of {len(pictures)} images that the corpus calls without contact")}


def _misshapen(where: Path, found: str, expected: str) -> BrokenLog:
    return BrokenLog(f"{where} holds {found}", expected, "Fetch the file again.", file=str(where))
