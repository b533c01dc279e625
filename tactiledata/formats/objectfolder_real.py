"""ObjectFolder-Real: a GelSight pressed on a hundred household objects, one folder of numbered PNGs a trial."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    Timeline,
    describe,
    files_in,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_key

TACTILE = "tactile_data"
CAMERA = "gelsight"


class ObjectFolderRealFormat(CorpusFormat):
    """ObjectFolder-Real: one source per object, one trajectory per trial."""

    name = "objectfolder_real"
    title = "ObjectFolder-Real (GelSight on 100 objects)"
    layout = "<object 1..100>/tactile_data/<trial>/0/gelsight/<n>.png"
    licence_note = "CC BY 4.0 says the project's page for ObjectFolder; check it, and cite Gao et al., CVPR 2023."

    def sniff(self, path: Path) -> bool:
        """Whether an object's ``tactile_data/<trial>/0/gelsight`` lies here or below."""
        return path.is_dir() and any(_is_object(folder) for folder in _objects(path))

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per object; a numbered folder without tactile data is one too, so that its lack is said."""
        self.require(path)
        return [self.make_source(path, folder, [image for _, image in _images(folder)]) for folder in _objects(path)]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """An object: its trials one after another, frames at the nominal rate by their numbers.

        Parameters
        ----------
        source : Source
            The folder of an object, as `sources` found it.
        intake : Intake
            Takes the images; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        folder = Path(source.path)
        thing = folder.resolve().name
        sensor = sensor_for(CAMERA, "objectfolder-real-gelsight", mapping)
        timeline, touches = Timeline(), []
        for trial in _trials(folder):
            images = files_in(trial / "0" / CAMERA, (".png",))
            _note_trial(trial, images, intake)
            if not trial.name.isdecimal() or not images:
                continue
            start = timeline.begin()
            name = f"object_{thing}-trial_{trial.name}"
            for index, image in zip(_indices(images, name, intake), images, strict=True):
                shown = f"{trial.name}/0/{CAMERA}/{image.name}"
                intake.image(CAMERA, image.read_bytes, timeline.at(index), sensor=sensor, trajectory=name, name=shown)
            extra = {"object": thing, "trial": trial.name, "sensor_in_corpus": CAMERA}
            touches.append(Trajectory(name, start, timeline.interval()[1], sensor, f"object_{thing}", extra))
        if not touches:
            raise_empty(source, f"{TACTILE}/<trial>/0/{CAMERA}/<n>.png")
        note_nominal_rate(intake, "the corpus")
        found = "sources disagree which GelSight this is; the corpus' own word is kept"
        intake.note("sensor-model-unsure", "info", found, CAMERA)
        description = describe(
            source, mapping, {sensor: CAMERA}, f"ObjectFolder-Real object {thing}", self.licence_note
        )
        return self.finish(source, intake, description, touches)


def _objects(path: Path) -> Iterator[Path]:
    if (path / TACTILE).is_dir():
        yield path
        return
    for folder in subfolders(path, 2, lambda name: name == TACTILE):
        if (folder / TACTILE).is_dir() or (folder.name.isdecimal() and _has_objects(folder.parent)):
            yield folder


def _has_objects(path: Path) -> bool:
    return any((folder / TACTILE).is_dir() for folder in path.iterdir())


def _is_object(folder: Path) -> bool:
    return any((trial / "0" / CAMERA).is_dir() for trial in _trials(folder))


def _trials(folder: Path) -> list[Path]:
    home = folder / TACTILE
    if not home.is_dir() or home.is_symlink():
        return []
    trials = [path for path in home.iterdir() if path.is_dir() and not path.is_symlink()]
    return sorted(trials, key=lambda path: natural_key(path.name))


def _images(folder: Path) -> Iterator[tuple[Path, Path]]:
    for trial in _trials(folder):
        for image in files_in(trial / "0" / CAMERA, (".png",)):
            yield trial, image


def _note_trial(trial: Path, images: Sequence[Path], intake: Intake) -> None:
    """What keeps a trial, or a part of it, out."""
    if not trial.name.isdecimal():
        found = f"trial {trial.name!r} is not a number and is left out with its {len(images)} images"
        intake.note("trial-name", "warning", found, trajectory=trial.name, count=max(len(images), 1))
        return
    if not (trial / "0" / CAMERA).is_dir():
        intake.note("folder-missing", "warning", f"{trial.name}/0/{CAMERA} is not there", trajectory=trial.name)
    elif not images:
        intake.note("folder-empty", "warning", f"{trial.name}/0/{CAMERA} holds no PNG", trajectory=trial.name)
    kept = {image.stem for image in images}
    others = files_in(trial / "0" / CAMERA, (".jpg", ".jpeg"))
    copies = sum(other.stem in kept for other in others)
    if copies:
        intake.note("converted-copies", "info", f"{copies} JPEG copies beside the PNGs are left out", count=copies)
    if len(others) > copies:
        found = f"{len(others) - copies} JPEGs without their PNG in trial {trial.name} are left out"
        intake.note("left-out", "warning", found, trajectory=trial.name, count=len(others) - copies)
    takes = [path for path in trial.iterdir() if path.is_dir()]
    if any(take.name != "0" or _other_folders(take) for take in takes):
        found = "folders beside the tactile images (cameras, further takes) are not read"
        intake.note("not-read", "info", found, "other")


def _other_folders(take: Path) -> bool:
    return any(path.is_dir() and path.name != CAMERA for path in take.iterdir())


def _indices(images: Sequence[Path], name: str, intake: Intake) -> list[int]:
    """Frame numbers counted from the first; the order alone where names are not plain, growing numbers."""
    numbers = [int(image.stem) if image.stem.isdecimal() else -1 for image in images]
    if min(numbers) < 0 or len(set(numbers)) < len(numbers) or max(numbers) - min(numbers) > 1_000_000:
        intake.note("frame-number", "info", f"{name}: file names are no plain frame numbers; their order is used")
        return list(range(len(images)))
    absent = numbers[-1] - numbers[0] + 1 - len(numbers)
    if absent:
        found = f"{name}: {absent} frame numbers between {numbers[0]} and {numbers[-1]} have no image"
        intake.note("frame-gap", "warning", found, CAMERA, name, count=absent)
    return [number - numbers[0] for number in numbers]
