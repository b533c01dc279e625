"""Facts of a store's sensors, held against the digests that the manifest has of them."""

from __future__ import annotations

from tactiledata.errors import StoreError
from tactiledata.store.layout.manifest import Manifest
from tactiledata.store.layout.places import COMMITTING, STAGING, home_of, sensors_path
from tactiledata.store.layout.sensors_table import Facts, changed_facts, parse_sensors
from tactiledata.store.read.files import StoreFiles, missing_file


def sensor_facts(files: StoreFiles, manifest: Manifest) -> Facts:
    """What is known of each sensor that a manifest names, by serial.

    Raises
    ------
    StoreError
        The facts of a sensor are not those that the manifest names.
    """
    place = sensors_path(home_of(manifest))
    try:
        content = files.read(place) if manifest["sensors"] else None
    except FileNotFoundError as error:
        raise missing_file(place, files.location) from error
    facts = parse_sensors(content, manifest, f"{files.location}/{place}")
    changed = changed_facts(facts, manifest)
    if not changed:
        return facts
    # a commit that goes on, or that was killed, kept the file as it was
    try:
        kept = parse_sensors(files.read(f"{STAGING}/{COMMITTING}"), manifest, STAGING)
    except (FileNotFoundError, StoreError):
        kept = facts
    if changed_facts(kept, manifest):
        raise StoreError(
            f"the facts of sensor {', '.join(changed)} in {files.location}/{place} are not those that were written",
            "facts that fit their SHA-256 in the manifest",
            "Take the file from a copy of the store; `tactiledata check` lists all damage.",
            sensors=changed,
        )
    return kept
