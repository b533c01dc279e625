"""Files of a store that are gone: which recordings lay in them, and the command that brings these back."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import LostFile, TactileDataError
from tactiledata.store.layout.places import TABLES, table_folder
from tactiledata.store.read.files import missing_file
from tactiledata.store.read.reader import Store

MOST_NAMED = 5
"""Recordings that a command names; of more, the folder that they lie in is asked for."""


def ingest_again(location: str, keys: Sequence[str]) -> str:
    """Return what brings recordings back into a store: the command, with the places of their files left open.

    Parameters
    ----------
    location : str
        Folder or address of the store.
    keys : sequence of str
        Names of the recordings.
    """
    if "://" in location:
        return "restore the file from a copy"
    places = [f"PATH/TO/{key}" for key in keys] if 0 < len(keys) <= MOST_NAMED else ["FOLDER_OF_THE_RECORDINGS"]
    command = shlex.join(["tactiledata", "ingest", *places, "--store", location, "--replace"])
    return f"restore the file from a copy, or ingest again what lay in it: `{command}`"


def lost_images(store: Store, faults: Sequence[tuple[int, str]]) -> tuple[list[Finding], list[tuple[int, str]]]:
    """Return a finding for each file of images that is gone, and the faults that have another reason.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    faults : sequence of (row, reason)
        Images that are damaged, as `payload_faults` gives them.
    """
    ending = missing_file("", store.location).found
    rows: dict[str, list[int]] = {}
    others = []
    for row, reason in faults:
        if reason.endswith(ending):
            rows.setdefault(reason.removesuffix(ending), []).append(row)
        else:
            others.append((row, reason))
    return [_lost_file(store, path, of_file) for path, of_file in rows.items()], others


def _lost_file(store: Store, path: str, rows: Sequence[int]) -> Finding:
    keys = _recordings_of(store, rows)
    whose = f" of {listed(keys, MOST_NAMED)}" if keys else ""
    text = f"the file {path} is missing: {counted(len(rows), 'image')}{whose} lay in it; "
    text += f"{ingest_again(store.location, keys)}; `check --repair` marks the images as broken"
    return Finding("store-payload", "damage", text, stream=path, count=len(rows))


def _recordings_of(store: Store, rows: Sequence[int]) -> list[str]:
    """Return the names of the recordings of some images; none where the tables do not tell."""
    try:
        names = store.sources(["key"])["key"].to_pylist()
        sources = np.asarray(store.frames(["source"])["source"])[list(rows)]
        return [names[number] for number in np.unique(sources).tolist()]
    except (TactileDataError, IndexError):
        return []


def need_tables(store: Store) -> None:
    """Refuse a store of whose index a file is gone.

    Raises
    ------
    LostFile
        One is.
    """
    for path in _table_files(store):
        if not (Path(store.location) / path).is_file():
            raise LostFile(
                f"{path} is missing in the store {store.location}",
                "every file that the manifest names",
                "Restore it from a copy, or ingest all recordings into a new store; nothing was added.",
                path=path,
            )


def _table_files(store: Store) -> Iterator[str]:
    for table in TABLES:
        yield from (f"{table_folder(table)}/{part['file']}" for part in store.manifest["index"][table])
