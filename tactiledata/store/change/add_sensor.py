"""A sensor added to a store by hand: its serial, its model and a picture of it without contact."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import MAX_DECODED_PIXELS
from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.picture_kinds import decode_said
from tactiledata.contract.records import Finding
from tactiledata.contract.take import Reference
from tactiledata.errors import BrokenLog, MissingFile, UsageError
from tactiledata.sensors import SENSORS
from tactiledata.sensors.average_background import average_background, refuse_swapped_channels
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.image_checks import CONTACT_LEVELS, is_one_colour, orientation_of, shows_contact
from tactiledata.store.change.keep_sensors import BY_HAND, keep_sensors, remove_picture
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.places import INTAKE_LOCK
from tactiledata.store.layout.sensors_table import image_crc, read_sensors
from tactiledata.store.read.free_air import free_air_median
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import recover

LARGEST_PICTURE = 64 * 2**20
"""Bytes of a picture file."""


def add_sensor(
    store_path: Path | str,
    name: str,
    background: Path | Sequence[Path],
    model: str | None = None,
    licence: str = "",
    source: str = "",
    replace: bool = False,
    unchecked: bool = False,
) -> list[Finding]:
    """What is worth saying after a sensor and its picture without contact became part of a store.

    The same picture again is no change.

    Parameters
    ----------
    store_path : Path
        A local store.
    name : str
        Serial, as recordings name it.
    background : Path or several
        JPEG or PNG; of several frames the mean is kept.
    model : str
        A name of the sensors table; where it is not given, what the store knows of the sensor, else ``digit``.
    licence, source : str
        Of the picture.
    replace : bool
        Put the picture in the place of another one, whether that was added or came with a recording.
    unchecked : bool
        Take the picture also where red and blue seem to be swapped, or the store's own frames of the sensor in free
        air look otherwise.

    Raises
    ------
    MissingFile, UsageError
        No picture there; not a picture; a touch in it; red and blue swapped; the store knows this sensor with another
        picture.
    UnknownName
        No such model.
    """
    if not name.strip() or name in {".", ".."} or len(name) > 200 or any(char in "/\\" or char < " " for char in name):
        raise UsageError(
            f"sensor name {name[:60]!r}",
            "1 to 200 characters without slashes and control characters",
            "Use the serial.",
        )
    paths = [background] if isinstance(background, Path) else list(background)
    names = [path.name for path in paths]
    read = [read_picture(path) for path in paths]
    said = [finding for _, remarks in read for finding in remarks]
    image = average_background([picture for picture, _ in read], names)
    folder = Path(store_path)
    Store.open(folder)  # says what is wrong where there is no store to lock
    with writing_lock(folder, INTAKE_LOCK):
        # what an ingest is staging right now must not be swept away
        manifest = recover(folder)
        facts = read_sensors(folder, manifest)
        known = facts.get(name, {}).get("model") or None
        if model is not None and known not in (None, model):
            raise UsageError(f"the store knows {name!r} as a {known}", f"--model {known}, not {model}", "Leave it out.")
        chosen = model or known or "digit"
        sensor = SENSORS[chosen]
        if not unchecked:
            _refuse_doubtful(Store.open(folder), name, image, sensor, " and ".join(names[:3]))
        there = manifest["references"].get(name)
        if there == image_crc(image) and name in facts:
            return said
        if there not in (None, image_crc(image)):
            _refuse_other(folder, name, replace)
            remove_picture(folder, name)
        reference = Reference(image, _origin(names, source), licence, chosen)
        keep_sensors(folder, {name: {**facts.get(name, {}), "model": chosen}}, {name: reference})
    return [*said, *_findings(name, image, sensor, len(paths))]


def _refuse_doubtful(store: Store, name: str, image: NDArray[np.uint8], sensor: Sensor, what: str) -> None:
    """Refuse a picture whose colours are swapped, or from which the store's own frames of the sensor in free air
    differ.
    """
    if sensor.name == "digit":
        refuse_swapped_channels(image, what)
    middle = free_air_median(store, name)
    if middle is None or middle.shape != image.shape:
        return
    contact = shows_contact(image, middle)
    if contact.is_contact:
        raise UsageError(
            f"{what} differs by {contact.score:.0f} grey levels from what {name!r} shows in free air in this store",
            f"the untouched sensor, less than {CONTACT_LEVELS:.0f} levels away",
            "It shows a touch, or the sensor was changed (then give it another name); --unchecked takes it as it is.",
        )


def _origin(names: Sequence[str], source: str) -> str:
    what = names[0] if len(names) == 1 else f"mean of {len(names)} frames ({names[0]} …)"
    return f"{BY_HAND}{what}{f', from {source}' if source else ''}"


def remove_sensor(store_path: Path | str, name: str) -> None:
    """Take out what was added by hand: the picture, and the sensor itself where no recording names it.

    Raises
    ------
    UsageError
        The store has no picture of it that was added by hand.
    """
    folder = Path(store_path)
    Store.open(folder)  # says what is wrong where there is no store to lock
    with writing_lock(folder, INTAKE_LOCK):
        recover(folder)
        store = Store.open(folder)
        if name not in store.manifest["references"] or not store.reference(name).origin.startswith(BY_HAND):
            raise UsageError(
                f"the store has no picture of {name!r} that was added by hand",
                "a sensor that `tactiledata sensors` lists as added by hand",
                "A picture that came with a recording goes with `tactiledata ingest RECORDING --replace`.",
            )
        remove_picture(folder, name)


def _refuse_other(folder: Path, name: str, replace: bool) -> None:
    if not replace:
        raise UsageError(
            f"the store has another picture of {name!r} ({Store.open(folder).reference(name).origin})",
            "a sensor that is new, or the same picture",
            "--replace puts this one in its place. A gel that was changed is another sensor: give it another name.",
        )


def read_picture(path: Path) -> tuple[NDArray[np.uint8], list[Finding]]:
    """The picture (H, W, 3) RGB in a file, and findings where it is not 8-bit RGB as stored."""
    if path.exists() and not path.is_file():
        what = "a folder" if path.is_dir() else "a pipe or a device"
        raise UsageError(f"{path} is {what}", "a JPEG or PNG file", "Name the picture's own file.")
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a JPEG or PNG file", "Check the spelling.", path=str(path))
    refuse_lfs_pointer(path)
    size = path.stat().st_size
    content = path.read_bytes() if size <= LARGEST_PICTURE else b""
    try:
        picture, remarks = decode_said(content, follow_orientation=True)
    except BrokenLog as error:
        raise UsageError(
            f"{path} ({size} bytes) is not a picture that can be read: {error.found}",
            f"a JPEG or PNG file of at most {MAX_DECODED_PIXELS} pixels",
            "Save it as 8-bit RGB PNG, cropped to the gel.",
        ) from error
    return picture, [Finding(remark.code, remark.severity, f"{path.name} {remark.words}") for remark in remarks]


def _findings(name: str, image: NDArray[np.uint8], sensor: Sensor, n_frames: int) -> list[Finding]:
    if sensor.camera is None:
        text = f"{sensor.title} gives no pictures; that of {name!r} was kept anyway"
        return [Finding("sensor-without-camera", "warning", text)]
    alone = f"{name!r} has one frame as its background: whether it shows a touch cannot be told; several frames tell"
    found = [Finding("background-one-frame", "info", alone)] if n_frames == 1 else []
    if is_one_colour(image):
        blank = f"the picture of {name!r} is of one colour throughout, as no picture of a gel is"
        found.append(Finding("background-blank", "warning", f"{blank}. Take it again with the light on"))
    rows, columns = sensor.camera.shape
    verdict = orientation_of(image, sensor)
    if verdict == "ok":
        return found
    size = f"{image.shape[0]} rows x {image.shape[1]} columns"
    text = f"the picture of {name!r} has {size}; a {sensor.name} gives {rows} x {columns}"
    if verdict == "swapped":
        return [*found, Finding("image-swapped", "warning", f"{text}: height and width swapped")]
    return [*found, Finding("image-size", "info", text)]
