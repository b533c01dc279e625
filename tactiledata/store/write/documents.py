"""The documents of a store beside its manifest, and their digests in it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from tactiledata.contract.atomic import readable_json, write_atomic
from tactiledata.contract.lfs_pointer import not_fetched
from tactiledata.contract.provenance import bytes_digest, digest_of
from tactiledata.errors import MissingFile, NotFetched, StoreError, TactileDataError
from tactiledata.store.layout.manifest import Manifest, read_manifest
from tactiledata.store.layout.places import CARD, home_of, sensors_path
from tactiledata.store.layout.sensors_table import Facts, read_sensors
from tactiledata.store.read.reader import Store
from tactiledata.store.write.recover import array_lengths, array_paths, is_interrupted, sensors_before

GROUP = "zarr.json"
POINTER = "is a Git LFS pointer, not the file"


def document_paths(manifest: Mapping[str, Any]) -> list[str]:
    """Paths of the documents that belong to what a manifest names: of all groups and arrays, and of the sensors."""
    arrays = array_paths(manifest)
    groups = {str(parent) for path in arrays for parent in PurePosixPath(path).parents} - {"."}
    paths = [GROUP, *(f"{path}/{GROUP}" for path in sorted(arrays | groups))]
    return [*paths, sensors_path(home_of(manifest))] if manifest["sensors"] else paths


def record_documents(folder: Path, manifest: Manifest) -> None:
    """The manifest names the digests of all documents as they are now; that of the card stays as it was.

    Of the sensors' file only those count that the manifest names: `drop_other_sensors` takes out the others once the
    manifest is there.
    """
    digests = {}
    for path in document_paths(manifest):
        if path == sensors_path(home_of(manifest)):
            digests[path] = bytes_digest(readable_json(read_sensors(folder, manifest)))
        elif (folder / path).is_file():
            digests[path] = bytes_digest((folder / path).read_bytes())
    if card := manifest.get("documents", {}).get(CARD):
        digests[CARD] = card
    manifest["documents"] = digests


def drop_other_sensors(folder: Path, manifest: Mapping[str, Any]) -> None:
    """The sensors' file holds those that the manifest names, and no others."""
    place = folder / sensors_path(home_of(manifest))
    content = readable_json(read_sensors(folder, manifest))
    if place.is_file() and place.read_bytes() != content:
        write_atomic(place, content)


def document_faults(store: Store) -> Iterator[tuple[str, str]]:
    """Path of each document that is not the one that its digest in the manifest is of, and what is wrong with it.

    After a commit that was interrupted, or one that came while the store was looked at, documents may be ahead of the
    manifest; they count as whole where cutting them to what it names gives what was recorded.
    """
    recorded = store.manifest.get("documents", {})
    for path in sorted({*recorded, *document_paths(store.manifest)} if recorded else ()):
        try:
            content = store.read_file(path)
        except (MissingFile, OSError):
            yield path, "is missing"
            continue
        except NotFetched:
            yield path, POINTER
            continue
        except StoreError:
            yield path, "is a pipe or a device, and no file"
            continue
        if path not in recorded:
            yield path, "has no digest in the manifest"
        elif bytes_digest(content) != recorded[path] and not _is_ahead(store, path, content):
            yield path, "is not the file that was written: it does not fit its SHA-256 in the manifest"


def _is_ahead(store: Store, path: str, content: bytes) -> bool:
    """Whether a document only has more than the manifest names, and a writer is, or was, there since."""
    folder = Path(store.location)
    if not folder.is_dir():
        return False
    if not is_interrupted(folder) and read_manifest(folder, checked=False, damaged=True) == store.manifest:
        return False
    # the card is written after the manifest
    recorded = store.manifest["documents"][path]
    return path == CARD or bytes_digest(_cut(folder, store.manifest, path, content)) == recorded


def _cut(folder: Path, manifest: Mapping[str, Any], path: str, content: bytes) -> bytes:
    """A document as the next writer will leave it, after an interrupted commit."""
    try:
        if path == sensors_path(home_of(manifest)):
            return readable_json(sensors_before(folder, manifest))
        document = json.loads(content)
        document["shape"][0] = array_lengths(manifest)[path.removesuffix(f"/{GROUP}")]
        return json.dumps(document, indent=2).encode()
    except (ValueError, TypeError, KeyError, IndexError, RecursionError, TactileDataError):
        return content


def known_sensors(store: Store) -> Facts:
    """Facts of a store's sensors as its manifest names them, also where an interrupted commit has added to them."""
    folder = Path(store.location)
    return sensors_before(folder, store.manifest) if folder.is_dir() else store.sensors()


def sensor_faults(store: Store) -> Iterator[tuple[str, str]]:
    """Each sensor whose facts are not those that the manifest has the digest of, and that in words."""
    for sensor, facts in known_sensors(store).items():
        if digest_of(facts) != store.manifest["sensors"][sensor]:
            yield sensor, f"the facts of sensor {sensor} are not those of the manifest"


def need_whole_documents(store: Store) -> None:
    """Refuse documents that do not fit their digests: a writer would take damage over and give it a fitting digest.

    Raises
    ------
    StoreError
        One does not.
    NotFetched
        The first that does not is a Git LFS pointer.
    """
    faults = [(path, f"{path} {fault}") for path, fault in document_faults(store) if path != CARD]
    if "documents" not in store.manifest:
        # written before documents had digests; the facts of sensors had theirs always
        faults = [(sensors_path(home_of(store.manifest)), fault) for _, fault in sensor_faults(store)]
    if faults:
        path, fault = faults[0]
        if fault.endswith(POINTER):
            raise not_fetched(f"{store.location}/{path}")
        raise StoreError(
            f"the store {store.location} is damaged: {fault}" + (f"; {len(faults) - 1} more" if faults[1:] else ""),
            "the documents that the manifest names",
            "`tactiledata check` lists all damage; restore those files from a copy, or ingest into a new store.",
            path=path,
        )
