"""Calibration packs of a GelSight: single presses of a ball, hand-annotated centre and radius, one NumPy archive."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LOG_FORMAT, LogDescription
from tactiledata.contract.image_bytes import IMAGE_SUFFIXES
from tactiledata.contract.records import Finding, Recording, Severity, Source, Trajectory, Values
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.contact_radius import radius_findings
from tactiledata.formats.reading.corpus import CorpusFormat, files_in, stream_name
from tactiledata.formats.reading.csv_cells import listed
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_paths
from tactiledata.formats.reading.npz_members import load_members, member_names
from tactiledata.sensors import SENSORS

MODEL = "gelsight_r15"
BALL = "ball"
BALL_RADIUS = 0.002
"""Metres, of the ball that pressed; stated where the pack was published. A mapping may give another."""

REQUIRED = ("f0", "imgs", "touch_center", "touch_radius")
EXPECTED = (*REQUIRED, "names", "img_size")

PUBLISHED_BACKGROUND = "51603f23ed977fa9"
"""Start of the SHA-256 of the background in ObjectFolder's pack."""

RECORDINGS = frozenset({".mcap", ".bag", ".db3", ".csv", ".yaml", ".hdf5", ".h5", ".pkl", ".tar"})
"""Endings of files beside which a pack does not speak for its folder."""

COLUMNS = ("touch_column", "touch_row", "touch_radius")


class GelsightPressesFormat(CorpusFormat):
    """A pack of presses: pictures come as BGR arrays and go in as RGB; each press is a trajectory of one frame.

    A pack has no clock (time stamps are indices) and no serial: the sensor is named after its background's digest, so
    that packs with one background agree and others differ; a mapping may name it. Pixels become lengths by the pitch
    of the sensor model, where the picture has that model's size.
    """

    name = "gelsight_presses"
    title = "GelSight calibration presses"
    layout = """
dataPack.npz            f0 (H, W, 3) BGR, without contact
                        imgs (n, H, W, 3) BGR, one press each
                        touch_center (n, 2) column and row, touch_radius (n,), px
                        names (n,), img_size (3,): optional
"""
    licence_note = "ObjectFolder's pack: CC BY 4.0, github.com/rhgao/ObjectFolder, calibs"

    def sniff(self, path: Path) -> bool:
        """Whether an .npz has the arrays of a pack, or a folder holds such ones and no other recordings."""
        if path.is_dir() and any(child.is_dir() or child.suffix.lower() in RECORDINGS for child in path.iterdir()):
            return False
        return bool(_packs(path))

    def sources(self, path: Path) -> Sequence[Source]:
        """Each archive is one recording."""
        self.require(path)
        return [self.make_source(path.absolute(), pack, [pack]) for pack in _packs(path.absolute())]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The presses, pushed in the order of the archive.

        Parameters
        ----------
        source : Source
            The archive of presses, as `sources` found it.
        intake : Intake
            Takes the images with their annotated touches, px; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        pack = _load(Path(source.path))
        description, sensor = _description(source, pack, mapping or {})
        model = str(description.sensors[sensor]["model"])
        radius = float(description.indenters[BALL].get("radius", math.nan))
        pitch = _pixel_pitch(model, pack.background.shape[:2])
        intake.declare("touch", (*COLUMNS, "touch_radius_metric"), ("px", "px", "px", "m"), "annotated by hand")
        trajectories = []
        for index, name in enumerate(_press_names(pack.names)):
            touch = pack.touches[index]
            trajectories.append(Trajectory(name, index, index + 1, sensor, BALL, _free_columns(touch, pitch)))
            intake.image(
                stream_name(model),
                lambda pixels=pack.images[index]: pixels,  # type: ignore[misc]
                index,
                sensor=sensor,
                trajectory=name,
                name=pack.names[index],
                values={"touch": [*touch, touch[2] * pitch]},
            )
        beside = files_in(Path(source.path).parent, tuple(IMAGE_SUFFIXES))
        if beside:
            message = f"{len(beside)} image files beside {Path(source.path).name} are not read: the pack holds its own"
            intake.note("images-beside", "info", message, count=len(beside))
        intake.note("no-clock", "info", f"{len(trajectories)} presses without times: stamps are their indices, in ns")
        references = {sensor: (pack.background, f"{source.key}: f0")}
        recording = self.finish(source, intake, description, trajectories, references=references)
        findings = (*pack.findings, *_scale_findings(source.key, pack, radius, pitch, model))
        return replace(recording, findings=(*recording.findings, *findings))


@dataclass
class _Pack:
    """The archive's arrays, checked against one another.

    ``background`` (H, W, 3) and ``images`` (n, H, W, 3) are uint8 RGB, ``touches`` (n, 3) column, row and radius in
    pixels, NaN where not annotated.
    """

    background: NDArray[np.uint8]
    images: NDArray[np.uint8]
    names: list[str]
    touches: Values
    findings: list[Finding] = field(default_factory=list)

    def note(self, code: str, severity: Severity, message: str, count: int = 1) -> None:
        self.findings.append(Finding(code, severity, message, count=count))


def _packs(path: Path) -> list[Path]:
    candidates = natural_paths(path.glob("*.npz")) if path.is_dir() else [path]
    return [child for child in candidates if set(REQUIRED) <= member_names(child) and not child.is_symlink()]


def _load(path: Path) -> _Pack:
    arrays, others = load_members(path, EXPECTED)
    missing = [name for name in REQUIRED if name not in arrays]
    if missing:
        raise BrokenLog(f"{path.name} has no {listed(missing)}", f"the arrays {listed(REQUIRED)}", file=str(path))
    background, images = arrays["f0"], arrays["imgs"]
    _check_pictures(path, background, images)
    pack = _Pack(
        np.ascontiguousarray(background[..., ::-1]),
        images[..., ::-1],
        _names(arrays.get("names"), len(images)),
        np.full((len(images), 3), np.nan),
    )
    _annotate(path, pack, arrays)
    if others:
        pack.note("members-ignored", "info", f"{path.name}: {listed(others[:5])} not known and not read", len(others))
    size = arrays.get("img_size")
    if size is not None and [*size.reshape(-1)[:2]] != [*background.shape[:2]]:
        message = f"{path.name} states the picture size {size.tolist()}, its pictures are {background.shape}"
        pack.note("size-misstated", "warning", message)
    return pack


def _check_pictures(path: Path, background: NDArray[Any], images: NDArray[Any]) -> None:
    is_picture = background.dtype == np.uint8 and background.ndim == 3 and background.shape[2] == 3 and background.size
    is_stack = images.dtype == np.uint8 and images.ndim == 4 and len(images) and images.shape[1:] == background.shape
    if not (is_picture and is_stack):
        raise BrokenLog(
            f"{path.name} has f0 {background.dtype} {background.shape} and imgs {images.dtype} {images.shape}",
            "f0 uint8 (H, W, 3) and imgs uint8 (n, H, W, 3), n > 0",
            "Save the pictures as the camera gave them, 8 bits a channel.",
            file=str(path),
        )


def _annotate(path: Path, pack: _Pack, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Fill ``pack.touches``; annotations that do not fit the pictures are reported and left NaN."""
    count = len(pack.images)
    for name, columns in (("touch_center", slice(0, 2)), ("touch_radius", slice(2, 3))):
        values, width = arrays[name], columns.stop - columns.start
        if values.dtype.kind not in "iuf" or values.size != len(values.reshape(-1)) or values.size % width:
            message = f"{path.name}: {name} is {values.dtype} {values.shape}, expected numbers ({count}, {width})"
            pack.note("annotation-unreadable", "damage", message, count)
            continue
        rows = values.reshape(-1, width).astype(float)
        if len(rows) != count:
            message = f"{path.name}: {name} has {len(rows)} rows for {count} pictures; taken in order"
            pack.note("annotation-count", "damage", message, abs(count - len(rows)))
        pack.touches[: len(rows), columns] = rows[:count]
    absent = ~np.isfinite(pack.touches).all(axis=1)
    if absent.any():
        message = f"{path.name}: {absent.sum()} of {count} presses have no whole annotation"
        pack.note("annotation-missing", "warning", message, int(absent.sum()))
    height, width = pack.background.shape[:2]
    column, row = pack.touches[:, 0], pack.touches[:, 1]
    with np.errstate(invalid="ignore"):
        outside = (column < 0) | (column >= width) | (row < 0) | (row >= height)
    if outside.any():
        message = f"{path.name}: {outside.sum()} annotated centres lie outside the picture of {height} x {width}"
        pack.note("touch-outside-picture", "warning", message, int(outside.sum()))


def _names(stated: NDArray[Any] | None, count: int) -> list[str]:
    """File names of the presses; indices where the pack has none, or another number of them."""
    if stated is None or stated.dtype.kind not in "US" or stated.size != count:
        return [str(index) for index in range(count)]
    texts = [value.decode(errors="replace") if isinstance(value, bytes) else str(value) for value in stated.ravel()]
    return [text or str(index) for index, text in enumerate(texts)]


def _press_names(names: Sequence[str]) -> list[str]:
    """Names of trajectories, each once."""
    stems = [f"press-{PurePosixPath(name).stem or name}" for name in names]
    return [stem if stems.count(stem) == 1 else f"{stem}~{index}" for index, stem in enumerate(stems)]


def _free_columns(touch: Values, pitch: float) -> dict[str, float | None]:
    """An annotation in pixels and in millimetres; ``None`` where it is not known."""
    columns: dict[str, float | None] = {}
    for name, value in zip(COLUMNS, touch.tolist(), strict=True):
        columns[f"{name}_px"] = value if math.isfinite(value) else None
        length = round(value * pitch * 1e3, 6)
        columns[f"{name}_mm"] = length if math.isfinite(length) else None
    return columns


def _description(source: Source, pack: _Pack, mapping: Mapping[str, Any]) -> tuple[LogDescription, str]:
    """What is known of the pack with what a mapping adds, and the sensor's name."""
    addition = mapping.get("description") or {}
    background = hashlib.sha256(pack.background[..., ::-1].tobytes()).hexdigest()
    sensor = next(
        (str(facts["sensor"]) for facts in mapping.get("images", {}).values() if "sensor" in facts),
        next(iter(addition.get("sensors", {})), f"gelsight-{background[:8]}"),
    )
    document: dict[str, Any] = {
        "format": LOG_FORMAT,
        "sensors": {sensor: {"model": MODEL}},
        "indenters": {BALL: {"shape": "sphere", "radius": BALL_RADIUS}},
    }
    if background.startswith(PUBLISHED_BACKGROUND):
        document |= {"title": "ObjectFolder: calibration of a GelSight R1.5", "licence": "CC BY 4.0"}
    return LogDescription(document, source.key).merged(addition, f"mapping for {source.key}"), sensor


def _pixel_pitch(model: str, shape: tuple[int, ...]) -> float:
    """Metres a pixel of a sensor model's camera; NaN where the model or the picture's size is another."""
    camera = SENSORS[model].camera if model in SENSORS else None
    return float(camera.pixel_pitch[0]) if camera is not None and camera.shape == shape else math.nan


def _scale_findings(name: str, pack: _Pack, radius: float, pitch: float, model: str) -> list[Finding]:
    """Radii held against the ball, where a length can be given to a pixel."""
    if not math.isfinite(pitch * radius):
        message = (
            f"{name}: no length of a pixel is known for {model} pictures of {pack.background.shape[:2]}: "
            "annotations stay in pixels, and radii were not checked"
        )
        return [Finding("scale-unknown", "warning", message)]
    annotated = pack.touches[:, 2][np.isfinite(pack.touches[:, 2])]
    return radius_findings(annotated, radius, pitch, f"contact radii in {name}", model)
