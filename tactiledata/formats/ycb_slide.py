"""YCB-Slide: a DIGIT slid by hand over YCB objects (real, tracked by OptiTrack) and the same in simulation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.contract.simulated import Kind
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    beside,
    describe,
    files_in,
    nominal_ns,
    note_nominal_rate,
    raise_empty,
    seconds_to_ns,
    sensor_for,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import last_number
from tactiledata.formats.reading.optitrack import JUMP_FACTOR, contact_poses, is_pose, nearest_rows, read_tracks
from tactiledata.formats.reading.restricted_pickle import load_npy, load_pickle
from tactiledata.units import SIGNAL_COLUMNS

MAX_CLOCK_DIFFERENCE = 20 * 60
"""Seconds by which the tracker may have started before the camera; the corpus' own limit."""

BACKGROUNDS: dict[str, int] = {
    "sugar_box": 0,
    "power_drill": 0,
    "tomato_soup_can": 1,
    "mustard_bottle": 2,
    "bleach_cleanser": 3,
    "mug": 4,
    "scissors": 5,
    "adjustable_wrench": 6,
    "hammer": 8,
    "baseball": 8,
}
"""Which background picture goes with which object: all that the corpus tells of the sensor's identity."""

REAL_CAMERAS = {"webcam": "webcam_frames"}
SIMULATED_CAMERAS = {"gt_heightmap": "gt_heightmaps", "gt_contactmask": "gt_contactmasks"}
SETTINGS = frozenset({"omegaconf"})
"""Packages of settings whose objects lie beside the simulated poses (``mNoise``); they are passed over."""
LICENCE = "MIT (its authors' README since September 2024; CC BY-SA 4.0 in copies from before)"
IMAGE_FOLDERS = {"frames", "tactile_images", *REAL_CAMERAS.values(), *SIMULATED_CAMERAS.values()}
REAL_NAME = re.compile(r"dataset_\d+")
POSE = SIGNAL_COLUMNS["tcp"]


def background_of(folder: str) -> int | None:
    """The background's number for an object folder such as ``035_power_drill``; ``None`` for other objects."""
    return BACKGROUNDS.get(re.sub(r"^\d+[_-]", "", folder))


@dataclass
class _Touch:
    """What one dataset_k says of itself."""

    times: NDArray[np.int64]
    frames: list[str]
    webcam: list[str]
    poses: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    extra: dict[str, Any] = field(default_factory=dict)


class YcbSlideFormat(CorpusFormat):
    """YCB-Slide, real and simulated; one source and one trajectory per ``dataset_k`` or simulated run."""

    name = "ycb_slide"
    title = "YCB-Slide (DIGIT sliding on YCB objects)"
    layout = """dataset/real/<obj>/{alignment.npy, <obj>.csv, dataset_<k>/…}
dataset/real/<obj>/dataset_<k>/{frames/*.jpg, webcam_frames/*.jpg, synced_data.npy, digit_data.npy}
dataset/sim/<obj>/<kk>/{tactile_images/*.jpg, gt_heightmaps/*.jpg, gt_contactmasks/*.jpg, tactile_data.pkl}"""
    licence_note = "MIT since September 2024, CC BY-SA 4.0 before; name the authors (Suresh et al., CoRL 2022)."

    def sniff(self, path: Path) -> bool:
        """Whether a ``dataset_k`` or a simulated run lies here or below."""
        return path.is_dir() and next(_runs(path), None) is not None

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per ``dataset_k`` and simulated run."""
        self.require(path)
        return [self.make_source(path, run.resolve().parent, _files(run.resolve()), run) for run in _runs(path)]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """Read one trajectory: its images, and its poses as signals, NaN where a pose was lost.

        Parameters
        ----------
        source : Source
            The corpus's folder, and in it the folder of the trajectory, as `sources` found them.
        intake : Intake
            Takes the images with their values; it is read afterwards for findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        folder = Path(source.path) / source.part
        thing = folder.parent.name
        is_simulated = _is_simulated(folder)
        sensor = sensor_for("digit", _sensor(thing, is_simulated, intake), mapping)
        touch = _simulated(folder, intake) if is_simulated else _real(folder, thing, intake)
        if not len(touch.times):
            raise_empty(source, "images in frames/ or tactile_images/")
        origin = "simulation" if is_simulated else "real"
        trajectory = f"{thing}-sim-{folder.name}" if is_simulated else f"{thing}-{folder.name}"
        signals = _signals(touch, folder, thing, intake, is_simulated)
        others = SIMULATED_CAMERAS if is_simulated else REAL_CAMERAS
        _push(touch, folder, sensor, trajectory, signals.get("contact_pose"), others, intake)
        start, end = int(touch.times.min()), int(touch.times.max()) + nominal_ns(1)
        extra = {"object": thing, "origin": origin, **touch.extra}
        taken = Trajectory(trajectory, start, end, sensor, thing, extra)
        models = {sensor: "digit"} | {beside(sensor, camera): "camera" for camera in intake.cameras if camera in others}
        kind: Kind = "simulated" if is_simulated else "real"
        description = describe(source, mapping, models, "YCB-Slide", LICENCE, kind)
        return self.finish(source, intake, description, [taken], signals)


def _sensor(thing: str, is_simulated: bool, intake: Intake) -> str:
    if is_simulated:
        return "ycb-slide-sim"
    background = background_of(thing)
    if background is None:
        found = f"the object {thing!r} is not in the table of backgrounds: its sensor stands alone"
        intake.note("sensor-unlisted", "warning", found)
        return f"ycb-slide-{thing}"
    return f"ycb-slide-bg{background}"


def _runs(path: Path) -> Any:
    for folder in subfolders(path, 4, lambda name: name in IMAGE_FOLDERS):
        if _is_simulated(folder) or _is_real(folder):
            yield folder


def _is_simulated(folder: Path) -> bool:
    return (folder / "tactile_data.pkl").is_file() or (
        (folder / "tactile_images").is_dir() and (folder / "gt_heightmaps").is_dir()
    )


def _is_real(folder: Path) -> bool:
    if any((folder / name).is_file() for name in ("synced_data.npy", "digit_data.npy")):
        return True
    frames = folder / "frames"
    return bool(REAL_NAME.fullmatch(folder.name)) and next(frames.glob("frame_*.jpg"), None) is not None


def _files(run: Path) -> list[Path]:
    inside = [run / name for name in ("synced_data.npy", "digit_data.npy", "tactile_data.pkl")]
    shared = [] if _is_simulated(run) else [run.parent / "alignment.npy", run.parent / f"{run.parent.name}.csv"]
    images = [path for name in sorted(IMAGE_FOLDERS) for path in files_in(run / name, (".jpg", ".jpeg", ".png"))]
    return [path for path in (*inside, *shared) if path.is_file()] + images


def _simulated(folder: Path, intake: Intake) -> _Touch:
    names = [f"tactile_images/{path.name}" for path in files_in(folder / "tactile_images", (".jpg", ".jpeg", ".png"))]
    numbers = [last_number(Path(name).name) for name in names]
    indices = [number if number is not None else row for row, number in enumerate(numbers)]
    stated = folder / "tactile_data.pkl"
    poses: dict[str, NDArray[np.float64]] = {}
    count = max(indices, default=-1) + 1
    if stated.is_file():
        content = load_pickle(stated, unread=SETTINGS)
        if not isinstance(content, dict):
            raise _misshapen(stated, f"a {type(content).__name__}", "a dict of poses")
        for key in ("gelposes", "camposes", "gelposes_meas"):
            if key in content:
                poses[key] = _pose_table(content[key], stated, key)
                count = max(count, len(poses[key]))
    else:
        intake.note("poses-missing", "warning", f"{stated.name} is not there: no poses")
    note_nominal_rate(intake, "the simulation")
    files = [""] * count
    for index, name in zip(indices, names, strict=True):
        files[index] = name
    times = np.array([nominal_ns(index) for index in range(count)], dtype=np.int64)
    return _Touch(times, files, [], poses)


def _real(folder: Path, thing: str, intake: Intake) -> _Touch:
    synced, plain = folder / "synced_data.npy", folder / "digit_data.npy"
    stated = synced if synced.is_file() else plain
    on_disk = [f"frames/{path.name}" for path in files_in(folder / "frames", (".jpg", ".jpeg", ".png"))]
    if not stated.is_file():
        intake.note(
            "poses-missing", "warning", "neither synced_data.npy nor digit_data.npy is there: no times, no poses"
        )
        note_nominal_rate(intake, "the folder of frames")
        return _Touch(np.array([nominal_ns(row) for row in range(len(on_disk))], dtype=np.int64), on_disk, [])
    content = load_npy(stated)
    if content is None and plain.is_file():
        # what the corpus' script writes where the starts of camera and tracker do not fit together
        found = f"{synced.name} is empty: the clocks of camera and tracker were not matched; {plain.name} is read"
        intake.note("poses-missing", "warning", found)
        stated, content = plain, load_npy(plain)
    if not isinstance(content, dict):
        raise _misshapen(stated, f"a {type(content).__name__}", "a pickled dict")
    times, is_good = seconds_to_ns(_either(content, "timestamps", "timestamp", stated))
    if not is_good.all():
        count = int((~is_good).sum())
        intake.note("time-broken", "damage", f"{count} time stamps are not numbers", "digit", count=count)
    frames = _names(content, ("digit_frames", "image_path"), folder, "frames")
    webcam = _names(content, ("webcam_frames", "webcam_path"), folder, "webcam_frames")
    touch = _Touch(times, frames, webcam, extra={"start_time": str(content.get("start_time", ""))})
    _complete(touch, on_disk, intake)
    poses = content.get("poses")
    if isinstance(poses, dict):
        touch.poses = {str(body): _pose_table(rows, stated, str(body)) for body, rows in poses.items()}
    else:
        touch.poses = _tracked(folder.parent, thing, touch, intake)
    return touch


def _either(content: Mapping[Any, Any], one: str, other: str, where: Path) -> Any:
    for key in (one, other):
        if key in content:
            return [np.nan if value is None else value for value in content[key]]
    raise _misshapen(where, f"keys {sorted(map(str, content))}", f"{one!r} or {other!r}")


def _names(content: Mapping[Any, Any], keys: tuple[str, str], folder: Path, home: str) -> list[str]:
    """Names of images below the folder; recorders that wrote longer paths are followed by the file's name."""
    stated: Sequence[Any] = next((content[key] for key in keys if key in content), [])
    names = []
    for name in [str(item) for item in stated]:
        inside = path_inside(folder, name, f"{folder.name}: {keys[0]}")
        names.append(name if inside.is_file() else f"{home}/{inside.name}")
    return names


def _complete(touch: _Touch, on_disk: list[str], intake: Intake) -> None:
    """Every time has a frame (or an empty name) and every frame on disk has a time, with a finding where not."""
    if len(touch.frames) not in (0, len(touch.times)):
        found = f"{len(touch.frames)} image names and {len(touch.times)} time stamps"
        intake.note("length-mismatch", "damage", found, "digit", count=abs(len(touch.frames) - len(touch.times)))
    if not touch.frames:
        by_number = {last_number(name): name for name in on_disk}
        touch.frames = [by_number.get(row, "") for row in range(len(touch.times))]
    named = set(touch.frames)
    unnamed = [name for name in on_disk if name not in named]
    touch.frames = touch.frames + [""] * (len(touch.times) - len(touch.frames)) + unnamed
    lacking = len(touch.frames) - len(touch.times)
    if lacking > 0:
        found = f"{lacking} images have no time stamp; they are put behind the last one at the nominal rate"
        intake.note("image-without-time", "warning", found, "digit", count=lacking)
        last = int(touch.times[-1]) if len(touch.times) else -nominal_ns(1)
        behind = [last + nominal_ns(row + 1) for row in range(lacking)]
        touch.times = np.concatenate([touch.times, np.array(behind, dtype=np.int64)])


def _tracked(home: Path, thing: str, touch: _Touch, intake: Intake) -> dict[str, NDArray[np.float64]]:
    """Poses from the tracker's own export, matched by start times and nearest sample as the corpus does."""
    export = home / f"{thing}.csv"
    if not export.is_file():
        intake.note("poses-missing", "warning", "no poses beside the frames and no OptiTrack export")
        return {}
    try:
        tracks = read_tracks(export, ["DIGIT", thing])
        ahead = (_clock(touch.extra["start_time"]) - _clock(tracks.start)).total_seconds()
    except (BrokenLog, ValueError) as error:
        intake.note("poses-missing", "warning", f"the OptiTrack export cannot be matched: {error}")
        return {}
    if not 0 <= ahead <= MAX_CLOCK_DIFFERENCE or not len(tracks.seconds):
        intake.note(
            "poses-missing", "warning", f"the camera started {ahead:.0f} s after the tracker: not one recording"
        )
        return {}
    intake.note("poses-from-optitrack", "info", f"poses are the nearest samples of {export.name}")
    rows = nearest_rows(tracks.seconds, touch.times / 1e9 + ahead)
    return {body: poses[rows] for body, poses in tracks.poses.items()}


def _clock(text: str) -> datetime:
    return datetime.strptime(text.replace(".", ":"), "%Y-%m-%d %I:%M:%S:%f %p")


def _pose_table(rows: Any, where: Path, what: str) -> NDArray[np.float64]:
    try:
        table = np.array([[np.nan if cell in (None, "") else cell for cell in row] for row in rows], dtype=np.float64)
        return table.reshape(-1, 7)
    except (ValueError, TypeError) as error:
        raise _misshapen(where, f"{what}: {error}", "rows of x y z and a quaternion x y z w, metres") from error


def _signals(touch: _Touch, folder: Path, thing: str, intake: Intake, is_simulated: bool) -> dict[str, Signal]:
    tables = {body: _fitted(rows, body, len(touch.times), intake) for body, rows in touch.poses.items()}
    if is_simulated:
        names = {"gelposes": "gel_pose", "camposes": "camera_pose", "gelposes_meas": "gel_pose_measured"}
        return {names[key]: _signal(names[key], touch.times, rows, "object") for key, rows in tables.items()}
    bodies = [body for body in tables if body != "DIGIT"]
    body = thing if thing in tables else (bodies[0] if bodies else "")
    signals = {}
    if "DIGIT" in tables:
        signals["digit_pose"] = _signal("digit_pose", touch.times, tables["DIGIT"], "optitrack")
    if body:
        signals["object_pose"] = _signal("object_pose", touch.times, tables[body], "optitrack")
    for other in [other for other in bodies if other != body]:
        intake.note("left-out", "warning", f"poses of a second object {other!r} are left out")
    for name, signal in signals.items():
        lost = int((~is_pose(signal.values)).sum())
        if lost:
            found = f"{name}: {lost} of {len(touch.times)} poses were lost by the tracker; they are NaN, images stay"
            intake.note("pose-lost", "warning", found, name, count=lost)
    if len(signals) == 2:
        alignment = _alignment(folder.parent / "alignment.npy", intake)
        poses, is_jump = contact_poses(signals["digit_pose"].values, signals["object_pose"].values, alignment)
        if is_jump.any():
            found = f"{int(is_jump.sum())} poses jump by more than {JUMP_FACTOR:.0f} mean steps; masked, images stay"
            intake.note("pose-jump", "warning", found, "contact_pose", count=int(is_jump.sum()))
        signals["contact_pose"] = _signal("contact_pose", touch.times, poses, "object")
    return signals


def _fitted(rows: NDArray[np.float64], body: str, count: int, intake: Intake) -> NDArray[np.float64]:
    if len(rows) == count:
        return rows
    found = f"{len(rows)} poses of {body} for {count} moments; the first are kept together, the rest is NaN"
    intake.note("length-mismatch", "damage", found, body, count=abs(len(rows) - count))
    fitted = np.full((count, 7), np.nan)
    fitted[: min(len(rows), count)] = rows[:count]
    return fitted


def _signal(name: str, times: NDArray[np.int64], rows: NDArray[np.float64], frame: str) -> Signal:
    return Signal(name, Stamps(times), rows, POSE, frame)


def _alignment(path: Path, intake: Intake) -> NDArray[np.float64]:
    if path.is_file():
        value = np.asarray(load_npy(path))
        if value.shape == (4, 4) and value.dtype.kind in "fiu" and np.isfinite(value).all():
            return value.astype(np.float64)
        intake.note("alignment-missing", "warning", f"{path.name} is not a 4x4 matrix: contact poses are not aligned")
    else:
        intake.note("alignment-missing", "warning", f"{path.name} is not there: contact poses are not aligned")
    return np.eye(4)


def _push(
    touch: _Touch,
    folder: Path,
    sensor: str,
    trajectory: str,
    contact: Signal | None,
    others: Mapping[str, str],
    intake: Intake,
) -> None:
    """All images in the order of their time; a moment without its image stays as a moment."""
    is_known: list[bool] = [] if contact is None else is_pose(contact.values).tolist()
    if contact is not None:
        note = "1 where the contact pose is known, 0 where the tracker lost it or it jumped"
        intake.declare("pose_known", ("known",), ("1",), note)
    companions = {camera: _by_number(folder / home) for camera, home in others.items()}
    if companions.get("gt_heightmap"):
        intake.note("heightmap-8bit", "info", "height maps are 8-bit: one level is about 0.03 mm", "gt_heightmap")
    for row, (moment, name) in enumerate(zip(touch.times.tolist(), touch.frames, strict=True)):
        path = folder / name
        is_there = bool(name) and path.is_file()
        if not is_there:
            intake.note("image-missing", "damage", f"{name or f'frame {row}'} is not there", "digit", trajectory)
        values = {"pose_known": [float(is_known[row])]} if len(is_known) else {}
        payload = path.read_bytes if is_there else None
        intake.image("digit", payload, moment, sensor=sensor, trajectory=trajectory, name=name, values=values)
        number = last_number(path.name) if name else row
        for camera, files in companions.items():
            other = files.pop(row if number is None else number, None)
            if other is not None:
                shown = f"{others[camera]}/{other.name}"
                whose = beside(sensor, camera)
                intake.image(camera, other.read_bytes, moment, sensor=whose, trajectory=trajectory, name=shown)
    for camera, files in companions.items():
        if files:
            found = f"{len(files)} images of {others[camera]} belong to no frame and are left out"
            intake.note("left-out", "warning", found, camera, trajectory, count=len(files))


def _by_number(folder: Path) -> dict[int, Path]:
    files = files_in(folder, (".jpg", ".jpeg", ".png"))
    numbered = {last_number(path.name): path for path in files}
    return {number: path for number, path in numbered.items() if number is not None}


def _misshapen(where: Path, found: str, expected: str) -> BrokenLog:
    return BrokenLog(f"{where} holds {found}", expected, "Fetch the file again.", file=str(where))
