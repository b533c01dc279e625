"""The manifest: what it names exists, what it does not name does not; it is written last."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.lfs_pointer import refuse_pointer_bytes
from tactiledata.contract.near_path import near_path
from tactiledata.contract.provenance import bytes_digest
from tactiledata.contract.schema import check_document
from tactiledata.contract.sealed import SEAL, fits_seal, sealed_json
from tactiledata.errors import MissingFile, NotAStore, SchemaError, StoreError
from tactiledata.store.layout.places import (
    FORMAT,
    FORMAT_NAME,
    FORMAT_VERSION,
    MANIFEST,
    TABLES,
    Settings,
    table_folder,
)
from tactiledata.store.layout.regular_files import need_regular

Manifest = dict[str, Any]
RECORDINGS = "`tactiledata ingest RECORDINGS --store NAME.zarr` makes a store of recordings."
"""What to do with a path that is named as a store and holds recordings."""

ADDRESS = re.compile(r"[a-z][a-z0-9+.-]+:/(?!/)")
"""How an address begins that was taken for a path, and so lost one of its two slashes."""


def empty_manifest(settings: Settings) -> Manifest:
    """The manifest of a store without sources."""
    return {
        "format": FORMAT,
        "settings": settings.document(),
        "rows": dict.fromkeys(TABLES, 0),
        "cameras": {},
        "signals": {},
        "aligned": {},
        "frame_values": {},
        "index": {table: [] for table in TABLES},
        "sources": [],
        "sensors": {},
        "references": {},
        "digest": bytes_digest(FORMAT.encode()),
    }


def extended_digest(digest: str, *additions: str) -> str:
    """A store's digest after additions, in order; it does not depend on how additions were grouped into commits."""
    for addition in additions:
        digest = bytes_digest(f"{digest}\n{addition}".encode())
    return digest


def settings_of(manifest: Mapping[str, Any]) -> Settings:
    """The sizes that a store was created with."""
    return Settings(**manifest["settings"])


def parse_manifest(content: bytes, where: str, checked: bool = True, damaged: bool = False) -> Manifest:
    """A manifest that fits ``schemas/store.json`` and its own digest, where it has one.

    Parameters
    ----------
    content : bytes
        Of the file.
    where : str
        The file, as errors name it.
    checked : bool
        Whether it is held against the schema.
    damaged : bool
        Whether a manifest is taken that does not fit its own digest, to look for further damage.

    Raises
    ------
    NotFetched
        A Git LFS pointer.
    StoreError
        Not a manifest, changed since it was written, or of a version that this code does not know.
    """
    refuse_pointer_bytes(content, where)
    try:
        manifest = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise StoreError(
            f"{where} is not JSON: {error}",
            "the manifest of a store",
            "Restore it from a copy, or ingest the recordings again.",
        ) from error
    name, _, version = str(manifest.get("format", "") if isinstance(manifest, dict) else "").partition("/")
    if name != FORMAT_NAME:
        raise StoreError(f"{where} says format {name!r}", f"{FORMAT!r}", "Name the folder of a tactiledata store.")
    if not version.isdigit() or int(version) > FORMAT_VERSION:
        raise StoreError(
            f"{where} has format version {version!r}",
            f"at most {FORMAT_VERSION}",
            "The store was written by a newer tactiledata; install that version to read it.",
            version=version,
        )
    if not damaged and (fault := seal_fault(content, manifest)):
        raise StoreError(
            f"{where} {fault}",
            "the file that was written",
            "Restore it from a copy, or ingest the recordings into a new store; `tactiledata check` looks for further "
            "damage.",
        )
    if checked:
        _check(content, where)
    return manifest


def seal_fault(content: bytes, manifest: Mapping[str, Any]) -> str:
    """How the bytes of a manifest differ from those that were written; empty where they fit, or nothing says."""
    return "is damaged: it does not fit its own SHA-256" if SEAL in manifest and not fits_seal(content) else ""


CHECKED_ENTRIES = 100
"""Entries of the long lists that are held against the schema at every opening; `check` looks at all of them."""


def _check(content: bytes, where: str) -> None:
    """Hold a manifest against the schema: of its sources, the first ``CHECKED_ENTRIES``."""
    try:
        _need_schema(content, CHECKED_ENTRIES)
    except SchemaError as error:
        raise StoreError(
            error.found.replace(MANIFEST, where, 1),
            "a manifest that fits schemas/store.json",
            "Restore it from a copy of the store, or ingest the recordings into a new store.",
            **{**error.facts, "file": where},
        ) from error


def need_manifest_schema(manifest: Manifest) -> None:
    """Refuse a manifest that does not fit ``schemas/store.json``, whatever its number of sources.

    Raises
    ------
    SchemaError
        It does not fit.
    """
    _need_schema(json.dumps(manifest).encode(), None)


@lru_cache(maxsize=8)
def _need_schema(content: bytes, most_sources: int | None) -> None:
    """Refuse the bytes of a manifest that does not fit the schema; the same bytes are checked once, in any store."""
    manifest = json.loads(content)
    sources = manifest.get("sources")
    shortened = {**manifest, "sources": sources[:most_sources] if isinstance(sources, list) else sources}
    check_document(shortened, "store", MANIFEST)


def read_manifest(store_path: Path | str, checked: bool = True, damaged: bool = False) -> Manifest:
    """The manifest of a local store; ``checked`` and ``damaged`` are those of `parse_manifest`.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    checked, damaged : bool
        As those of `parse_manifest`.

    Raises
    ------
    MissingFile
        There is no such folder.
    StoreError
        The folder is not a store, or of another version.
    """
    folder = Path(store_path)
    need_regular(folder / MANIFEST)
    try:
        content = (folder / MANIFEST).read_bytes()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise not_a_store(str(folder), folder.exists()) from error
    return parse_manifest(content, str(folder / MANIFEST), checked, damaged)


def not_a_store(location: str, exists: bool) -> MissingFile | StoreError:
    """The error for a place without a manifest: a store that lost it has other files of one, a wrong call has none."""
    if not exists and ADDRESS.match(location):
        return MissingFile(
            f"the store {location} is not on a local disk",
            "a local store",
            "This writes into the store: run it where the store lies, or copy the store here first.",
            path=location,
        )
    if not exists:
        return MissingFile(
            f"there is no store at {location}",
            "the folder or URL of a store",
            near_path(Path(location), [".zarr"]) or "Check the name, or make the store with `tactiledata ingest`.",
            path=location,
        )
    if Path(location).exists() and not Path(location).is_dir():
        return NotAStore(
            f"{location} is not a store: it is no folder",
            "a folder that `tactiledata ingest` wrote",
            f"Name the folder of the store (its name usually ends in .zarr). {RECORDINGS}",
            path=location,
        )
    if has_tables(location):
        return StoreError(
            f"{location} has no {MANIFEST}, but other files of a store",
            "a whole store",
            f"Restore {MANIFEST} from a copy, or ingest the recordings into a new store.",
            path=location,
        )
    return NotAStore(
        f"{location} is not a store: it has no {MANIFEST}",
        "a folder that `tactiledata ingest` wrote",
        f"Name the folder that holds {MANIFEST} (its name usually ends in .zarr). {RECORDINGS}",
        path=location,
    )


def has_tables(location: Path | str) -> bool:
    """Whether tables of a store lie in a local folder: without a manifest it is one that lost it."""
    return any(Path(location, table_folder(table)).is_dir() for table in TABLES)


def write_manifest(store_path: Path, manifest: Manifest) -> None:
    """The manifest on disk, whole and with its own digest, after everything that it names."""
    write_atomic(store_path / MANIFEST, sealed_json(manifest))
