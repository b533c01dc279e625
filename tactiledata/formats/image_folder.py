"""A plain folder of tactile images: pictures in natural order, no clock, no forces, no poses."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.image_bytes import IMAGE_SUFFIXES, ImageHeader, read_header
from tactiledata.contract.own_files import is_own_picture
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Finding, Recording, Source, Trajectory
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import BrokenLog, UsageError
from tactiledata.formats.reading.backgrounds import load_backgrounds, noted_background, read_image_file
from tactiledata.formats.reading.corpus import CorpusFormat, files_in, raise_empty, stream_name
from tactiledata.formats.reading.csv_cells import listed
from tactiledata.formats.reading.described import camera_topics, described_trajectories
from tactiledata.formats.reading.intake import Intake

ANY_CAMERA = "tactile"
"""Stream name of images whose sensor's model is not known."""

OTHERS = frozenset({"log.yaml", "metadata.yaml"})
"""Files that make a folder a recording of another format."""
OTHER_SUFFIXES = frozenset({".mcap", ".bag", ".db3"})

PART_OF_A_LOG = "backgrounds"
TABLE_OF_A_LOG = "frames.csv"
"""A folder of that name, or beside such a table, belongs to a log, also to one whose log.yaml was lost."""

_BACKGROUND = re.compile(r"(background|bg)\.(png|jpe?g)", re.IGNORECASE)
_MASK = re.compile(r".+_mask\.png", re.IGNORECASE)


@dataclass
class _Folder:
    """What lies in a folder of images."""

    images: list[Path] = field(default_factory=list)
    background: Path | None = None
    masks: list[Path] = field(default_factory=list)
    unsafe: list[str] = field(default_factory=list)
    others: list[str] = field(default_factory=list)
    drawn: list[str] = field(default_factory=list)


class ImageFolderFormat(CorpusFormat):
    """A plain folder of images: each file one frame, the folder one trajectory, files in natural order.

    There is no clock, so time stamps are the frames' indices (0, 1, 2 ... ns): order, and nothing else. A file
    ``background.*`` or ``bg.*`` is the picture without contact of the sensor that a mapping names. ``*_mask.png`` in
    8-bit grey is an annotation and is left. A mapping can name the sensor and the stream
    (``images: {digit: {topic: <folder's name>, sensor: D20542}}``) and cut the folder into trajectories
    (``description: {trajectories: [...]}``, intervals of indices).
    """

    name = "image_folder"
    says_links = False
    takes_subfolders = False
    title = "folder of images"
    layout = """
<folder>/*.png|jpg      one frame each, in natural order
         background.png without contact (or bg.png, or jpg), optional
         *_mask.png     8-bit grey, left
"""

    def sniff(self, path: Path) -> bool:
        """Whether a folder holds images itself, and nothing that makes it a recording of another kind."""
        is_part = path.name == PART_OF_A_LOG or (path.parent / TABLE_OF_A_LOG).exists()
        if is_part or not path.is_dir():
            return False
        try:
            files = [child for child in path.iterdir() if child.is_file() and not child.name.startswith(".")]
        except OSError:
            return False
        if any(child.name.lower() in OTHERS or child.suffix.lower() in OTHER_SUFFIXES for child in files):
            return False
        return any(child.suffix.lower() in IMAGE_SUFFIXES and not _is_drawn(child) for child in files)

    def sources(self, path: Path) -> Sequence[Source]:
        """The folder; folders below it are recordings of their own."""
        self.require(path)
        return [self.make_source(path.absolute(), path.absolute(), files_in(path.absolute(), tuple(IMAGE_SUFFIXES)))]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The images, pushed in natural order.

        Parameters
        ----------
        source : Source
            A folder of JPEG or PNG images, as `sources` found it.
        intake : Intake
            Takes the images; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it may name the camera, the sensor and trajectories.
        """
        root = Path(source.path)
        camera, sensor = _camera(root, mapping or {})
        description = _description(source, sensor, camera, mapping or {})
        found = _look(root, {str(facts.get("background", "")) for facts in description.sensors.values()})
        if not found.images:
            raise_empty(source, "at least one JPEG or PNG image that is no mask and no background")
        if not sensor and len(description.sensors) == 1:
            sensor = next(iter(description.sensors))
        _note_folder(intake, found)
        whole = Trajectory(root.name, 0, len(found.images), sensor)
        trajectories = described_trajectories(description) or [whole]
        for index, path in enumerate(found.images):
            touch = next((touch for touch in trajectories if touch.start_ns <= index < touch.end_ns), None)
            taken_by = sensor if touch is None else touch.sensor or sensor
            intake.image(
                camera or _model(description, taken_by),
                lambda path=path: read_image_file(path),  # type: ignore[misc]
                index,
                sensor=taken_by,
                trajectory="" if touch is None else touch.name,
                name=path.name,
            )
        references, findings = _references(intake, description, root, found, sensor)
        recording = self.finish(source, intake, description, trajectories, references=references)
        return replace(recording, findings=(*recording.findings, *findings))


def _look(root: Path, named: Collection[str]) -> _Folder:
    """The files of a folder by what they are; links are not followed, backgrounds named elsewhere are no frames."""
    found = _Folder()
    for path in sorted(root.iterdir()):
        if path.is_dir() or path.name.startswith("."):
            continue
        if path.suffix.lower() not in IMAGE_SUFFIXES:
            found.others.append(path.name)
        elif path.is_symlink():
            found.unsafe.append(path.name)
    for path in files_in(root, tuple(IMAGE_SUFFIXES)):
        if path.name.startswith(".") or path.name in named:
            continue
        if _BACKGROUND.fullmatch(path.name) and found.background is None:
            found.background = path
        elif _MASK.fullmatch(path.name) and _is_grey(path):
            found.masks.append(path)
        elif _is_drawn(path):
            found.drawn.append(path.name)
        else:
            found.images.append(path)
    return found


def _is_drawn(path: Path) -> bool:
    """Whether a file is a picture that a command of the toolkit drew, such as that of a page."""
    try:
        return is_own_picture(path)
    except OSError:
        return False  # what cannot be read is told where it is read


def _is_grey(path: Path) -> bool:
    header = _header(path)
    return header is not None and header.channels == 1 and header.bits == 8


def _header(path: Path) -> ImageHeader | None:
    try:
        return read_header(read_image_file(path))
    except (OSError, BrokenLog):
        return None


def _note_folder(intake: Intake, found: _Folder) -> None:
    intake.note(
        "no-clock",
        "info",
        f"{counted(len(found.images), 'image')} without times: stamps are their indices in natural order, in ns",
    )
    for code, severity, names, one, several in (
        ("mask-left", "info", [path.name for path in found.masks], "is a mask (8-bit grey), no tactile image; left",
         "are masks (8-bit grey), not tactile images; left"),
        ("not-an-image", "info", found.others, "is neither JPEG nor PNG; left", "are neither JPEG nor PNG; left"),
        ("picture-drawn", "info", found.drawn, "was drawn by a command of tactiledata, and is no tactile image; left",
         "were drawn by commands of tactiledata, and are no tactile images; left"),
        ("link-left", "warning", found.unsafe, "is a link, which is not followed; copy the image into the folder",
         "are links, which are not followed; copy the images into the folder"),
    ):  # fmt: skip
        if names:
            more = f" and {len(names) - 5} more" if len(names) > 5 else ""
            words = f"{listed(names[:5])}{more} {agreeing(len(names), one, several)}"
            intake.note(code, severity, words, count=len(names))  # type: ignore[arg-type]


def _camera(root: Path, mapping: Mapping[str, Any]) -> tuple[str, str]:
    """Stream and sensor that a mapping gives the folder; empty where it says nothing."""
    images = mapping.get("images", {})
    fitting = [name for name, facts in images.items() if {root.name, "."} & set(camera_topics(facts))] or list(images)
    if len(fitting) > 1:
        raise UsageError(
            f"the mapping names {len(fitting)} cameras for the folder {root.name}: {listed(fitting)}",
            "one, whose topic is the folder's name",
            f"Write `topic: {root.name}` at the camera that took these images.",
        )
    return (fitting[0], str(images[fitting[0]].get("sensor", ""))) if fitting else ("", "")


def _description(source: Source, sensor: str, camera: str, mapping: Mapping[str, Any]) -> LogDescription:
    """What the mapping says of the folder; a sensor that it only names is described by its stream's name."""
    addition = mapping.get("description")
    stated: dict[str, Any] = {}
    if sensor and sensor not in (addition or {}).get("sensors", {}):
        stated = {"sensors": {sensor: {"model": camera}}}
    if not addition and not stated:
        return LogDescription({}, source.key)
    return LogDescription(stated, source.key).merged(addition or {}, f"mapping for {source.key}")


def _model(description: LogDescription, sensor: str) -> str:
    model = str(description.sensors.get(sensor, {}).get("model", ""))
    return stream_name(model) if model else ANY_CAMERA


def _references(
    intake: Intake, description: LogDescription, root: Path, found: _Folder, sensor: str
) -> tuple[dict[str, tuple[NDArray[np.uint8], str]], tuple[Finding, ...]]:
    """Pictures without contact by sensor, with their origin: what the mapping names, else the folder's own file."""
    loaded = load_backgrounds(description, lambda name, where: path_inside(root, name, where))
    references = {serial: (picture, loaded.origins[serial]) for serial, picture in loaded.references.items()}
    if found.background is not None and sensor not in references:
        if not sensor:
            message = f"{found.background.name} is left: no sensor is named, so it cannot be told whose it is"
            intake.note("background-without-sensor", "warning", f"{message}; name the sensor in a mapping")
        elif (picture := noted_background(found.background, intake, f"background {found.background.name}")) is not None:
            references[sensor] = picture, found.background.name
    return references, loaded.findings
