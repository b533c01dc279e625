"""Sensors that no recording brought: kept in a store, and taken out of it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactiledata.contract.provenance import digest_of
from tactiledata.contract.take import Reference
from tactiledata.store.layout.arrays import open_root, write_image
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest, extended_digest
from tactiledata.store.layout.places import home_of, reference_path
from tactiledata.store.layout.sensors_table import image_crc, read_sensors, write_sensors
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import changing

BY_HAND = "added by hand: "
"""How the origin of a picture begins that was added by hand: it goes before those of recordings."""


def keep_sensors(
    store_path: Path | str, facts: Mapping[str, Mapping[str, Any]], references: Mapping[str, Reference]
) -> Manifest:
    """The manifest after facts and pictures of sensors became part of a store that had no such pictures.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    facts : dict of dict
        Facts by sensor; they replace what the store knew of that sensor.
    references : dict of Reference
        Pictures without contact (height, width, 3) uint8 with their origin, licence and model, by sensor.
    """
    with changing(store_path) as (folder, manifest):
        with Batch(folder) as batch:
            root = open_root(batch)
            given = {name: dict(facts.get(name, {})) for name in sorted({*facts, *references})}
            manifest["sensors"] = write_sensors(batch, manifest, {**read_sensors(folder, manifest), **given})
            for sensor, reference in sorted(references.items()):
                attributes = {"sensor": sensor, "origin": reference.origin, "licence": reference.licence}
                path = reference_path(home_of(manifest), sensor)
                write_image(root, path, reference.image, {**attributes, "model": reference.model})
                manifest["references"][sensor] = image_crc(reference.image)
            batch.publish()
        for sensor in given:
            crc = manifest["references"].get(sensor)
            manifest["digest"] = extended_digest(
                manifest["digest"], f"sensor {sensor} {digest_of(given[sensor])} {crc}"
            )
    return manifest


def remove_picture(store_path: Path | str, sensor: str) -> Manifest:
    """The manifest after a sensor's picture left a store, and the sensor with it where no recording names it."""
    contents = Store.open(store_path).sources(["contents"])["contents"].to_pylist()
    named = any(sensor in json.loads(text)["sensors"] for text in contents)
    with changing(store_path) as (_, manifest):
        del manifest["references"][sensor]
        if not named:
            # its facts stay in their file, where the manifest does not name them: a kill must not part the two
            manifest["sensors"].pop(sensor, None)
        manifest["digest"] = extended_digest(manifest["digest"], f"no picture of {sensor}")
    return manifest
