"""The file of the trajectories that a person called bad: ``flags.json`` beside a store's manifest.

It is no part of the manifest, as splits are none: what a person thinks of a trajectory is no fact of its recording, and
it may be said while a writer is at work. Flags go by the uid of a trajectory, so that they hold wherever it is kept.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.schema import check_document
from tactiledata.contract.sealed import fits_seal, sealed_json
from tactiledata.errors import SchemaError
from tactiledata.store.layout.places import FLAGS, FLAGS_LOCK

FORMAT = "tactiledata-flags/1"
TRIES = 10
"""Writings that are tried: a commit that begins meanwhile sweeps away files that are being written."""

WRITTEN = b"flags.json was written\n"
"""What the lock's file holds once there are flags: from then on their file stays, and shows when it is lost."""

FlagEntries = dict[str, dict[str, Any]]
"""What ``schemas/flags.json`` says of each flag, by the uid of its trajectory."""


def parse_flags(content: bytes, where: str) -> FlagEntries:
    """The flags in the bytes of ``flags.json``, by uid.

    Parameters
    ----------
    content : bytes
    where : str
        The file, as errors name it.

    Raises
    ------
    SchemaError
        It is not the file that was written.
    """
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict) or not fits_seal(content):
        raise SchemaError(
            f"{where} is not the file that was written",
            f"the flags of trajectories, as {FORMAT}, with the SHA-256 of the file",
            f"Take it from a copy of the store. Without one, remove it and {FLAGS_LOCK}, and flag trajectories again.",
            path="$",
            file=where,
        )
    check_document(document, "flags", where)
    return document["flags"]


def write_flags(folder: Path, entries: Mapping[str, Mapping[str, Any]]) -> None:
    """Write the flags of a local store, whole or not at all; a store without flags and without the file needs none."""
    place = folder / FLAGS
    if not entries and not place.is_file():
        return
    content = sealed_json({"format": FORMAT, "flags": {uid: dict(entry) for uid, entry in entries.items()}})
    for attempt in range(TRIES):
        try:
            write_atomic(place, content)
        except FileNotFoundError:
            if attempt + 1 == TRIES or not folder.is_dir():
                raise
        else:
            break
    lock = folder / FLAGS_LOCK
    if not lock.is_file() or lock.read_bytes() != WRITTEN:
        lock.write_bytes(WRITTEN)
