"""Whether the files of the splits in a store are those that were written."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from tactiledata.contract.provenance import bytes_digest
from tactiledata.contract.records import Finding
from tactiledata.contract.schema import check_document
from tactiledata.contract.sealed import SEAL, fits_seal
from tactiledata.errors import NotFetched, SchemaError, TactileDataError
from tactiledata.store.read.reader import Store


def split_findings(store: Store) -> Iterator[Finding]:
    """Tables of splits that are missing or changed, and tables that no document vouches for."""
    files = store.names("splits")
    vouched, unsealed = set(), []
    for name in files:
        if not name.endswith(".json"):
            continue
        try:
            content = store.read_file(f"splits/{name}")
            document = json.loads(content)
            if SEAL in document and not fits_seal(content):
                fault = f"splits/{name} is not the file that was written: it does not fit its own SHA-256"
                yield _damage(fault, name)
            elif SEAL not in document:
                _need_older(document, name)
                unsealed.append(name)
            table = document["table"] if str(document["format"]).startswith("tactiledata-split/") else None
            vouched |= {table["file"]} if table else set()
            fault = _table_fault(store, files, table["file"], table["sha256"]) if table else ""
        except NotFetched as error:
            fault = error.found
        except (ValueError, TypeError, KeyError, RecursionError, TactileDataError):
            fault = f"splits/{name} cannot be read"
        if fault:
            yield _damage(fault, name)
    if unsealed:
        message = f"no digest is recorded in splits/{', splits/'.join(unsealed)} (written before they had one)"
        yield Finding("store-no-digest", "info", f"{message}; draw the split again to get one", count=len(unsealed))
    for name in files:
        if name.endswith(".parquet") and name not in vouched:
            message = f"splits/{name} has no document that vouches for it; draw the split anew"
            yield Finding("store-split", "damage", message, stream=name)


def _damage(fault: str, name: str) -> Finding:
    return Finding("store-split", "damage", f"{fault}; take it from a copy, or draw the split anew", stream=name)


def _need_older(document: Mapping[str, Any], name: str) -> None:
    """Refuse a document without a digest unless its kind was once written without: a name may have changed.

    Raises
    ------
    SchemaError
        It is not.
    """
    kind, _, version = str(document["format"]).partition("/")
    if kind == "tactiledata-split":
        check_document(document, "split", name)
    elif version != "1":
        raise SchemaError(f"{name} has no digest", f"a field {SEAL}", path="$", file=name)


def _table_fault(store: Store, files: list[str], file: str, sha256: str) -> str:
    if file not in files:
        return f"splits/{file} is missing"
    if bytes_digest(store.read_file(f"splits/{file}")) != sha256:
        return f"splits/{file} is not the table that its document names"
    return ""
