"""Names of the splits that were made of a store, so that one that is gone with all its files is noticed.

The names stand beside the folder ``splits/``, not in the manifest: a split needs no writing lock, and the manifest
holds facts of recordings only. A name is added after the files of its split are written, so that a kill at any moment
leaves no name without a split. Each writing adds the splits that are there, so that two processes at once forget none
for long.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.sealed import fits_seal, sealed_json
from tactiledata.errors import SchemaError
from tactiledata.store.layout.places import MADE_SPLITS

FORMAT = "tactiledata-splits/1"


def made_names(content: bytes) -> list[str]:
    """Names of the splits that were made, by the bytes of the store's list of them.

    Raises
    ------
    SchemaError
        It is not the file that was written.
    """
    try:
        document = json.loads(content) if fits_seal(content) else {}
    except (ValueError, RecursionError):
        document = {}
    names = document.get("names")
    if document.get("format") != FORMAT or not isinstance(names, list):
        raise SchemaError(
            f"{MADE_SPLITS} is not the file that was written",
            f"the names of splits, as {FORMAT}",
            "`tactiledata check --repair` writes it anew.",
            path="$",
            file=MADE_SPLITS,
        )
    return [str(name) for name in names]


def names_on_disk(folder: Path) -> list[str]:
    """Names of the splits of a local store whose table and document are there, sorted."""
    splits = folder / "splits"
    return sorted(place.stem for place in splits.glob("*.json") if place.with_suffix(".parquet").is_file())


def write_names(folder: Path, names: Iterable[str]) -> None:
    """The list of a local store's splits, whole or not at all; it stays untouched where it says that already."""
    content = sealed_json({"format": FORMAT, "names": sorted(set(names))})
    place = folder / MADE_SPLITS
    if not place.is_file() or place.read_bytes() != content:
        write_atomic(place, content)


def remember_split(folder: Path, name: str) -> None:
    """Add a split to the list of a local store, and with it every other one that is there.

    Parameters
    ----------
    folder : Path
        The store.
    name : str
        Of a split whose table and document are written.
    """
    place = folder / MADE_SPLITS
    try:
        known = made_names(place.read_bytes())
    except (FileNotFoundError, SchemaError):
        known = []
    write_names(folder, [*known, *names_on_disk(folder), name])
