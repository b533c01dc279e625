"""A sensor added to a store by hand: its serial, its model and a picture of it without contact."""

from __future__ import annotations

import copy
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.records import Finding
from tactiledata.errors import MissingFile, UsageError
from tactiledata.sensors import SENSORS
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.image_checks import orientation_of
from tactiledata.store.arrays import open_root, write_image
from tactiledata.store.batch import Batch
from tactiledata.store.card import write_card
from tactiledata.store.commit import recover, store_errors
from tactiledata.store.layout import COMMITTING, INTAKE_LOCK, STAGING, reference_path
from tactiledata.store.lock import writing_lock
from tactiledata.store.manifest import extended_digest, read_manifest, write_manifest
from tactiledata.store.sensors_table import image_crc, read_sensors, write_sensors

LARGEST_PICTURE = 64 * 2**20
"""Bytes of a picture file."""


def add_sensor(
    store_path: Path | str, name: str, background: Path, model: str | None = None, licence: str = ""
) -> list[Finding]:
    """What is worth saying after a sensor and its picture without contact became part of a store.

    The same picture again is no change.

    Parameters
    ----------
    store_path : Path
        A local store.
    name : str
        Serial, as recordings name it.
    background : Path
        JPEG or PNG.
    model : str
        A name of the sensors table; where it is not given, what the store knows of the sensor, else ``digit``.
    licence : str
        Of the picture.

    Raises
    ------
    MissingFile, UsageError
        No picture there; not a picture; the store knows this sensor with another picture.
    UnknownName
        No such model.
    """
    if not name.strip() or "/" in name or "\\" in name or len(name) > 200:
        raise UsageError(f"sensor name {name[:60]!r}", "1 to 200 characters without slashes", "Use the serial.")
    image = read_picture(background)
    folder = Path(store_path)
    with writing_lock(folder, INTAKE_LOCK):
        # what an ingest is staging right now must not be swept away
        recover(folder)
    with store_errors(folder), writing_lock(folder):
        manifest = copy.deepcopy(read_manifest(folder))
        facts = read_sensors(folder, manifest)
        crc = image_crc(image)
        if manifest["references"].get(name, crc) != crc:
            raise UsageError(
                f"the store has another picture of {name!r}",
                "a sensor that is new, or the same picture",
                "A background that changed is another look of the sensor: give it a name of its own.",
            )
        known = facts.get(name, {}).get("model") or None
        if model is not None and known not in (None, model):
            raise UsageError(f"the store knows {name!r} as a {known}", f"--model {known}, not {model}", "Leave it out.")
        chosen = model or known or "digit"
        sensor = SENSORS[chosen]
        if name in manifest["references"] and name in facts:
            return []
        # a kill from here on leaves the manifest as it was, and the next writer clears what is beside it
        marker = folder / STAGING / COMMITTING
        write_atomic(marker, b"")
        facts[name] = {**facts.get(name, {}), "model": chosen}
        with Batch(folder) as batch:
            attributes = {"sensor": name, "origin": background.name, "licence": licence, "model": chosen}
            write_image(open_root(batch), reference_path(name), image, attributes)
            manifest["references"][name] = crc
            manifest["sensors"] = write_sensors(batch, facts)
            batch.publish()
        manifest["digest"] = extended_digest(manifest["digest"], f"sensor {name} {chosen} {crc}")
        write_manifest(folder, manifest)
        marker.unlink()
        write_card(folder, manifest)
    return _findings(name, image, sensor)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """The picture (H, W, 3) RGB in a file."""
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a JPEG or PNG file", "Check the spelling.", path=str(path))
    size = path.stat().st_size
    content = path.read_bytes() if size <= LARGEST_PICTURE else b""
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB) if content else None
    if image is None:
        raise UsageError(
            f"{path} ({size} bytes) is not a picture that can be read", "a JPEG or PNG file", "Save it as PNG."
        )
    return np.ascontiguousarray(image, dtype=np.uint8)


def _findings(name: str, image: NDArray[np.uint8], sensor: Sensor) -> list[Finding]:
    if sensor.camera is None:
        text = f"{sensor.title} gives no pictures; that of {name!r} was kept anyway"
        return [Finding("sensor-without-camera", "warning", text)]
    rows, columns = sensor.camera.shape
    verdict = orientation_of(image, sensor)
    if verdict == "ok":
        return []
    size = f"{image.shape[0]} rows x {image.shape[1]} columns"
    text = f"the picture of {name!r} has {size}; a {sensor.name} gives {rows} x {columns}"
    if verdict == "swapped":
        return [Finding("image-swapped", "warning", f"{text}: height and width swapped")]
    return [Finding("image-size", "info", text)]
