"""TVL: touch, vision and language; a handheld DIGIT with a camera (HCT) and robot presses (SSVTP), with captions."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.backgrounds import noted_background
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    Timeline,
    beside,
    describe,
    files_in,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.modality import DECISION, look_of, votes_tactile
from tactiledata.formats.reading.natural_order import last_number, natural_key

TABLES = ("train.csv", "test.csv")
LISTS = {"contact.json": 1.0, "not_contact.json": 0.0}
IMAGES = (".jpg", ".jpeg", ".png")
SAMPLED = 8
"""Pictures of each folder that are looked at when tactile and vision are told apart."""
MAX_LIST_BYTES = 256 * 2**20


@dataclass
class _Pair:
    """One touch and its photograph, as names below the part's folder; empty where not given."""

    tactile: str
    vision: str
    background: str = ""
    caption: str = ""
    table: str = ""
    contact: float = float("nan")


@dataclass
class _Sequence:
    pairs: list[_Pair] = field(default_factory=list)
    captions: list[str] = field(default_factory=list)


class TvlFormat(CorpusFormat):
    """TVL: one source per part (``ssvtp``, and one level deeper ``hct/data1`` …), a trajectory per recorded folder."""

    name = "tvl"
    title = "TVL (touch, vision, language; DIGIT)"
    layout = """hct/data<k>/{train.csv, test.csv: vision, tactile, background, caption}
hct/data<k>/{contact.json, not_contact.json, <sequence>/tactile/*.jpg, <sequence>/vision/*.jpg}
ssvtp/{images_tac/image_<n>_tac.jpg, images_rgb/image_<n>_rgb.jpg, text/labels_<n>.txt, train.csv, test.csv}"""
    licence_note = "Read the data set's card (mlfu7/Touch-Vision-Language-Dataset); captions partly come from GPT-4V."

    def sniff(self, path: Path) -> bool:
        """Whether a part of the corpus lies here or below."""
        return path.is_dir() and next(_parts(path), None) is not None

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per part."""
        self.require(path)
        return [self.make_source(path, part, _files(part)) for part in _parts(path)]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """Read a part: its sequences one after another, the two images of a pair at one moment.

        Parameters
        ----------
        source : Source
            A folder of the part, as `sources` found it.
        intake : Intake
            Takes the images with their published part and caption; it is read afterwards for findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        folder = Path(source.path)
        name = folder.resolve().name if _is_ssvtp(folder) else f"hct-{folder.resolve().name}"
        pairs = _listed(folder, intake)
        if not pairs:
            raise_empty(source, "pairs in train.csv, test.csv, contact.json or images_tac/")
        sensor = sensor_for("digit", f"tvl-{name}", mapping)
        sequences = _grouped(pairs, intake)
        note_nominal_rate(intake, "the corpus")
        intake.declare("published_part", ("part",), ("1",), "0 train.csv, 1 test.csv, as published")
        intake.declare("in_contact", ("in_contact",), ("1",), "0 where the corpus lists the image as not in contact")
        intake.declare("caption", ("caption",), ("1",), "index into the trajectory's list of captions")
        timeline, touches = Timeline(), []
        swapped = _swapped_homes(folder, pairs, intake)
        for touch, sequence in sequences.items():
            timeline.begin()
            for index, pair in enumerate(sequence.pairs):
                _push(folder, pair, sequence, timeline.at(index), sensor, touch, _homes(pair) in swapped, intake)
            extra: dict[str, Any] = {"part": name, "captions": json.dumps(sequence.captions, ensure_ascii=False)}
            extra |= {"modality_swapped": 1} if any(_homes(pair) in swapped for pair in sequence.pairs) else {}
            touches.append(Trajectory(touch, *timeline.interval(), sensor, "", extra))
        references = _reference(folder, pairs, sensor, swapped, intake)
        models = {sensor: "digit", beside(sensor, "vision"): "camera"}
        description = describe(source, mapping, models, f"TVL {name}", self.licence_note)
        return self.finish(source, intake, description, touches, references=references)


def _parts(path: Path) -> Iterator[Path]:
    below = subfolders(path, 3, lambda name: name in ("images_tac", "images_rgb", "text"))
    for folder in (one for one in below if one.parent.name == "hct" or len(one.relative_to(path).parts) < 3):
        if _is_ssvtp(folder) or any(_has_columns(folder / table) for table in TABLES) or _has_lists(folder):
            yield folder


def _is_ssvtp(folder: Path) -> bool:
    return (folder / "images_tac").is_dir() and (folder / "images_rgb").is_dir()


def _has_columns(table: Path) -> bool:
    try:
        with table.open(encoding="utf-8-sig", newline="") as stream:
            header = stream.readline(4096).lower()
    except (OSError, UnicodeDecodeError):
        return False
    return {cell.strip(' "\r\n') for cell in header.split(",")} >= {"tactile", "caption"}


def _has_lists(folder: Path) -> bool:
    path = folder / "contact.json"
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        start = stream.read(2**16)
    return b'"tactile"' in start or b'"vision"' in start


def _files(part: Path) -> list[Path]:
    named = [part / name for name in (*TABLES, *LISTS) if (part / name).is_file()]
    return named + [path for folder in subfolders(part, 3) for path in files_in(folder, (*IMAGES, ".txt"))]


def _listed(folder: Path, intake: Intake) -> list[_Pair]:
    """All pairs that tables and lists name, each tactile image once; SSVTP's folders where there is no table."""
    pairs: dict[str, _Pair] = {}
    unnamed: list[_Pair] = []
    for pair in [*_from_tables(folder, intake), *_from_lists(folder, intake)]:
        known = pairs.get(pair.tactile)
        if not pair.tactile:
            unnamed.append(pair)
        elif known is None:
            pairs[pair.tactile] = pair
        elif not pair.table:
            known.contact = pair.contact  # the list adds to what the table says
        else:
            intake.note("duplicate-key", "warning", f"{pair.table}: {pair.tactile} again; the first counts", pair.table)
    if _is_ssvtp(folder):
        for pair in _from_folders(folder, intake):
            pairs.setdefault(pair.tactile, pair)
    for pair in (*pairs.values(), *unnamed):
        for name in (pair.tactile, pair.vision, pair.background):
            path_inside(folder, name, f"a list of {folder.name}")
    return [*pairs.values(), *unnamed]


def _from_tables(folder: Path, intake: Intake) -> Iterator[_Pair]:
    for table in TABLES:
        path = folder / table
        if not path.is_file():
            continue
        try:
            with path.open(encoding="utf-8-sig", newline="") as stream:
                rows = csv.DictReader(stream)
                first = (rows.fieldnames or [""])[0]
                for number, row in enumerate(rows, start=2):
                    yield _row(row, first, table, number, intake)
        except (UnicodeDecodeError, csv.Error) as error:
            intake.note("table-broken", "damage", f"{table} cannot be read to its end ({error})", table)


def _row(row: Mapping[str, Any], first: str, table: str, number: int, intake: Intake) -> _Pair:
    cells = {str(key).strip().lower(): str(value or "").strip() for key, value in row.items() if key is not None}
    vision = cells.get("vision", cells.get(first.strip().lower(), ""))
    pair = _Pair(cells.get("tactile", ""), vision, cells.get("background", ""), cells.get("caption", ""), table, 1.0)
    for what, cell in (("tactile", pair.tactile), ("vision", pair.vision), ("caption", pair.caption)):
        if not cell:
            # that a touch has no image is said as damage where its moment is kept
            intake.note("csv-cell-empty", "warning", f"{table} line {number}: {what} is empty", f"{table}:{what}")
    return pair


def _from_lists(folder: Path, intake: Intake) -> Iterator[_Pair]:
    for name, contact in LISTS.items():
        path = folder / name
        if not path.is_file():
            continue
        try:
            if path.stat().st_size > MAX_LIST_BYTES:
                raise BrokenLog(f"{path.stat().st_size} bytes")
            content = json.loads(path.read_bytes())
            columns = {key: [str(item) for item in content.get(key, [])] for key in ("tactile", "vision", "background")}
        except (ValueError, TypeError, AttributeError, RecursionError) as error:
            intake.note("list-broken", "damage", f"{name} cannot be read ({str(error)[:100]})", name)
            continue
        count = max(map(len, columns.values()))
        if len({len(column) for column in columns.values() if column}) > 1:
            found = f"{name}: " + ", ".join(f"{len(column)} of {key}" for key, column in columns.items())
            intake.note("count-mismatch", "damage", found, name)
            count = min(len(column) for column in columns.values() if column)
        for row in range(count):
            picked = {key: column[row] if row < len(column) else "" for key, column in columns.items()}
            yield _Pair(**picked, contact=contact)


def _from_folders(folder: Path, intake: Intake) -> Iterator[_Pair]:
    """SSVTP's pairs by the number in their names, captions from text/."""
    photographs = {last_number(path.stem): path.name for path in files_in(folder / "images_rgb", IMAGES)}
    for path in files_in(folder / "images_tac", IMAGES):
        number = last_number(path.stem)
        text = folder / "text" / f"labels_{number}.txt"
        caption = text.read_text("utf-8", "replace").partition("\n")[0].strip() if text.is_file() else ""
        photograph = photographs.pop(number, "")
        vision = f"images_rgb/{photograph}" if photograph else ""
        yield _Pair(f"images_tac/{path.name}", vision, "", caption, "", 1.0)
    if photographs:
        found = f"{len(photographs)} photographs have no tactile image and are left out"
        intake.note("left-out", "warning", found, "vision", count=len(photographs))


def _grouped(pairs: Sequence[_Pair], intake: Intake) -> dict[str, _Sequence]:
    """Pairs by the folder that they were recorded into, train and test together; SSVTP's presses stand alone."""
    sequences: dict[str, _Sequence] = {}
    for pair in pairs:
        sequences.setdefault(_sequence_of(pair), _Sequence()).pairs.append(pair)
    torn = 0
    for sequence in sequences.values():
        sequence.pairs.sort(key=lambda pair: natural_key(PurePosixPath(pair.tactile or pair.vision).name))
        sequence.captions = sorted({pair.caption for pair in sequence.pairs if pair.caption})
        torn += len({pair.table for pair in sequence.pairs if pair.table}) > 1
    if torn:
        found = f"train.csv and test.csv share {torn} of {len(sequences)} sequences; they are kept together here"
        intake.note("published-split-leaks", "warning", found, count=torn)
    return dict(sorted(sequences.items(), key=lambda item: natural_key(item[0])))


def _sequence_of(pair: _Pair) -> str:
    path = PurePosixPath(pair.tactile or pair.vision)
    home = path.parent
    if home.name.startswith("images_"):
        number = last_number(path.stem)
        return path.stem if number is None else f"image_{number}"
    if home.name in ("tactile", "vision"):
        home = home.parent
    return home.as_posix() if home.as_posix() != "." else "all"


def _homes(pair: _Pair) -> tuple[str, str]:
    """The folders of a pair's two images."""
    return PurePosixPath(pair.tactile).parent.as_posix(), PurePosixPath(pair.vision).parent.as_posix()


def _swapped_homes(folder: Path, pairs: Sequence[_Pair], intake: Intake) -> set[tuple[str, str]]:
    """Pairs of folders that hold each other's images: a known defect of the corpus, seen by their statistics."""
    homes: dict[tuple[str, str], list[_Pair]] = {}
    for pair in pairs:
        if pair.tactile and pair.vision:
            homes.setdefault(_homes(pair), []).append(pair)
    swapped = set()
    for home, members in homes.items():
        tactile = _some(folder, [pair.tactile for pair in members])
        vision = _some(folder, [pair.vision for pair in members])
        if not tactile or not vision:
            continue
        votes = votes_tactile(look_of(tactile), look_of(vision))
        shown = f"{home[0]} and {home[1]} ({votes:.1f} of 4 votes)"
        if votes < -DECISION:
            swapped.add(home)
            found = f"touch and photographs are in each other's place in {shown}; read the other way round"
            intake.note("modality-swapped", "warning", found, trajectory=_sequence_of(members[0]))
        elif votes < DECISION:
            found = f"touch and photographs cannot be told apart in {shown}; read as named"
            intake.note("modality-unsure", "info", found, trajectory=_sequence_of(members[0]))
    return swapped


def _some(folder: Path, names: Sequence[str]) -> list[NDArray[np.uint8]]:
    """A few of the pictures, spread over the sequence."""
    there = [name for name in names if name]
    pictures = []
    for row in np.unique(np.linspace(0, len(there) - 1, min(len(there), SAMPLED)).astype(int)) if there else []:
        try:
            pictures.append(decode_rgb(_found(folder, there[row]).read_bytes()))
        except (BrokenLog, OSError):
            continue
    return pictures


def _found(folder: Path, name: str) -> Path:
    return path_inside(folder, name, f"a list of {folder.name}")


def _push(
    folder: Path, pair: _Pair, sequence: _Sequence, t_ns: int, sensor: str, touch: str, is_swapped: bool, intake: Intake
) -> None:
    """The touch, then its photograph, at one moment."""
    tactile, vision = (pair.vision, pair.tactile) if is_swapped else (pair.tactile, pair.vision)
    values: dict[str, list[float]] = {}
    if pair.table:
        values["published_part"] = [float(TABLES.index(pair.table))]
    if np.isfinite(pair.contact):
        values["in_contact"] = [pair.contact]
    if pair.caption:
        values["caption"] = [float(sequence.captions.index(pair.caption))]
    path = _found(folder, tactile) if tactile else None
    is_there = path is not None and path.is_file()
    if not is_there:
        intake.note("image-missing", "damage", f"{tactile or 'a tactile image'} is not there", "digit", touch)
    payload = path.read_bytes if path is not None and is_there else None
    intake.image("digit", payload, t_ns, sensor=sensor, trajectory=touch, name=tactile, values=values)
    photograph, whose = _found(folder, vision) if vision else None, beside(sensor, "vision")
    if photograph is not None and photograph.is_file():
        intake.image("vision", photograph.read_bytes, t_ns, sensor=whose, trajectory=touch, name=vision)
    elif vision:
        intake.note("image-missing", "damage", f"{vision} is not there", "vision", touch)


def _reference(
    folder: Path, pairs: Sequence[_Pair], sensor: str, swapped: set[tuple[str, str]], intake: Intake
) -> dict[str, tuple[NDArray[np.uint8], str]]:
    """The first background picture that is there; the corpus has one per sequence, a sensor is kept one."""
    photographs = {home for home, _ in swapped}
    stated = dict.fromkeys(pair.background for pair in pairs if pair.background)
    named = [name for name in stated if PurePosixPath(name).parent.as_posix() not in photographs]
    if len(named) > 1:
        found = f"{len(named)} background pictures are named, one per sequence; the first that is there is kept"
        intake.note("several-backgrounds", "info", found, "digit", count=len(named))
    for name in (*named, "digit_background.png"):
        path, what = _found(folder, name), f"background {name} of the corpus"
        if path.is_file() and (picture := noted_background(path, intake, what)) is not None:
            return {sensor: (picture, what)}
    return {}
