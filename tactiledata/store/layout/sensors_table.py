"""Sensors of a store: their facts, their pictures without contact, and what happens when recordings disagree."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.atomic import readable_json
from tactiledata.contract.lfs_pointer import refuse_pointer_bytes
from tactiledata.contract.provenance import digest_of, json_bytes
from tactiledata.contract.records import Finding
from tactiledata.errors import StoreError
from tactiledata.sensors.same_sensor import SAME_GEL_LEVELS, levels_apart
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.places import home_of, sensors_path

PASSING = ("power_on_ns",)
"""Facts that belong to a recording, not to a sensor; they stay in the source's description."""

Facts = dict[str, dict[str, Any]]


def merged_facts(
    known: Mapping[str, Mapping[str, Any]], stated: Mapping[str, Mapping[str, Any]]
) -> tuple[Facts, list[Finding]]:
    """Facts of all sensors after a recording stated some: what was known stays, gaps are filled, conflicts are said."""
    facts = {sensor: dict(values) for sensor, values in known.items()}
    findings = []
    for sensor, values in sorted(stated.items()):
        mine = facts.setdefault(sensor, {})
        for key, value in sorted(values.items()):
            if key in PASSING or value in (None, "", {}, []):
                continue
            if key not in mine:
                mine[key] = value
            elif mine[key] != value:
                findings.append(_conflict(sensor, f"{key} is {value!r} here and {mine[key]!r} in the store"))
    return facts, findings


def reference_conflict(sensor: str, known: NDArray[np.uint8], stated: NDArray[np.uint8]) -> Finding | None:
    """A finding where two pictures without contact cannot be of the same sensor.

    Parameters
    ----------
    sensor : str
        Serial, for the message.
    known, stated : (height, width, 3) uint8
        The picture that the store holds, and the one that a recording brings.
    """
    if known.shape != stated.shape:
        return _conflict(
            sensor, f"the picture without contact is {stated.shape[:2]} here and {known.shape[:2]} in the store"
        )
    difference = levels_apart(known, stated)
    if difference <= SAME_GEL_LEVELS:
        return None
    return _conflict(
        sensor, f"the picture without contact differs from the store's by {difference:.1f} levels in the mean"
    )


def _conflict(sensor: str, what: str) -> Finding:
    message = f"sensor {sensor}: {what}; the store keeps what came first. Two sensors with one serial?"
    return Finding("sensor-conflict", "warning", message, stream=sensor)


def image_crc(image: NDArray[np.uint8]) -> int:
    """CRC-32C of a picture's bytes, as the manifest keeps it."""
    return google_crc32c.value(np.ascontiguousarray(image).tobytes())


def parse_sensors(content: bytes | None, manifest: Mapping[str, Any], where: str) -> Facts:
    """Facts of the sensors that a manifest names, from the content of ``sensors.json``.

    Parameters
    ----------
    content : bytes, optional
        Of ``sensors.json``; ``None`` where the file is not there.
    manifest : dict
        Names the sensors.
    where : str
        The file, as errors name it.

    Raises
    ------
    NotFetched
        The content is a Git LFS pointer.
    StoreError
        It is no JSON, or lacks a sensor that the manifest names.
    """
    if not manifest["sensors"]:
        return {}
    refuse_pointer_bytes(content or b"", where)
    try:
        facts = json.loads(content or b"")
        named = {sensor: facts[sensor] for sensor in manifest["sensors"]}
        json_bytes(named)  # half of a letter and NaN, which Python reads, have no digest
        return named
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise StoreError(
            f"{where} does not hold the sensors that the manifest names: {error}",
            f"facts of {', '.join(sorted(manifest['sensors']))}",
            "Restore the file from a copy of the store.",
        ) from error


def changed_facts(facts: Facts, manifest: Mapping[str, Any]) -> list[str]:
    """Sensors whose facts do not fit the digests of a manifest."""
    return [sensor for sensor, values in facts.items() if digest_of(values) != manifest["sensors"][sensor]]


def read_sensors(store_path: Path, manifest: Mapping[str, Any]) -> Facts:
    """Facts of the sensors of a local store."""
    place = store_path / sensors_path(home_of(manifest))
    return parse_sensors(place.read_bytes() if place.is_file() else None, manifest, str(place))


def write_sensors(batch: Batch, manifest: Mapping[str, Any], facts: Facts) -> dict[str, str]:
    """Facts in their file; returns their digests for the manifest.

    Parameters
    ----------
    batch : Batch
        Takes the file.
    manifest : dict
        Says where the file lies.
    facts : dict of dict
        Facts of all sensors of the store, by sensor.
    """
    batch.write(sensors_path(home_of(manifest)), readable_json(facts))
    return {sensor: digest_of(values) for sensor, values in sorted(facts.items())}
