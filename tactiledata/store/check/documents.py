"""Whether the manifest and the documents of a store are the files that were written."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tactiledata.contract.lfs_pointer import pointer_words
from tactiledata.contract.records import Finding
from tactiledata.contract.sealed import SEAL
from tactiledata.store.layout.manifest import seal_fault
from tactiledata.store.layout.places import CARD, MANIFEST
from tactiledata.store.read.reader import Store
from tactiledata.store.write.documents import POINTER, document_faults


def document_findings(store: Store) -> Iterator[Finding]:
    """Documents that do not fit their digests, and a store that was written before there were digests of them."""
    if fault := seal_fault(store.read_file(MANIFEST), store.manifest):
        message = f"{MANIFEST} {fault}; take it from a copy, or ingest into a new store"
        yield Finding("store-manifest", "damage", message)
    if SEAL not in store.manifest or "documents" not in store.manifest:
        message = (
            "no digests of manifest.json and the other documents are recorded (written before stores kept them), so "
            "that they could not be checked; `check --repair` records them as they are now"
        )
        yield Finding("store-no-digest", "info", message, stream=MANIFEST)
    for path, fault in document_faults(store):
        if path == CARD:
            yield Finding("store-card", "warning", f"{path} {fault}; `check --repair` writes it anew", stream=path)
        elif fault == POINTER:
            if not Path(store.location).is_dir():  # of a local store, one finding names all pointers
                yield Finding("store-not-fetched", "damage", pointer_words(path), stream=path)
        else:
            yield Finding("store-document", "damage", f"{path} {fault}; take it from a copy", stream=path)
