"""Sensors of takes on their way into a store, whose facts and pictures stay as they came first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Reference
from tactiledata.store.layout.arrays import open_rows, write_image
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest
from tactiledata.store.layout.places import home_of, reference_path
from tactiledata.store.layout.sensors_table import (
    Facts,
    image_crc,
    merged_facts,
    read_sensors,
    reference_conflict,
    write_sensors,
)
from tactiledata.store.write.writer import StagedTake


class SensorAppender:
    """Adds the sensors of takes to a store's, whose facts and pictures stay as they came first.

    Parameters
    ----------
    batch : Batch
    root : zarr.Group
        The store's group, to create arrays in.
    manifest : dict
        Changed in place.
    """

    def __init__(self, batch: Batch, root: zarr.Group, manifest: Manifest) -> None:
        self._batch, self._root, self._manifest = batch, root, manifest
        self._home = home_of(manifest)
        self._facts = read_sensors(batch.root, manifest)
        self._images: dict[str, NDArray[np.uint8]] = {}

    def add(self, take: StagedTake) -> list[Finding]:
        """One take; where it contradicts what is known."""
        self._facts, findings = merged_facts(self._facts, take.document["sensors"])
        known = self._manifest["references"]
        for sensor, entry in take.document["references"].items():
            image = np.asarray(take.array(entry["arrays"]["image"]))
            if sensor not in known:
                self._write(sensor, image, entry["attributes"])
            elif conflict := reference_conflict(sensor, self._image(sensor), image):
                findings.append(conflict)
        return findings

    def keep_pictures(self, pictures: Mapping[str, Reference]) -> None:
        """Pictures that were added by hand, before any take is added: they stay."""
        for sensor, reference in sorted(pictures.items()):
            facts = {name: getattr(reference, name) for name in ("origin", "licence", "model")}
            self._write(sensor, reference.image, facts)

    def fill_facts(self, facts: Facts) -> None:
        """What was said by hand and no take says."""
        self._facts, _ = merged_facts(self._facts, facts)

    def finish(self) -> None:
        """Write the facts of all sensors."""
        if self._facts:
            self._manifest["sensors"] = write_sensors(self._batch, self._manifest, self._facts)

    def _write(self, sensor: str, image: NDArray[np.uint8], attributes: Mapping[str, Any]) -> None:
        write_image(self._root, reference_path(self._home, sensor), image, {"sensor": sensor, **attributes})
        self._manifest["references"][sensor] = image_crc(image)
        self._images[sensor] = image

    def _image(self, sensor: str) -> NDArray[np.uint8]:
        if sensor not in self._images:
            self._images[sensor] = np.asarray(open_rows(self._batch, reference_path(self._home, sensor))[...], np.uint8)
        return self._images[sensor]
