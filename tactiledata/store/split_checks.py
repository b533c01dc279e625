"""Whether the files of the splits in a store are those that were written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator

from tactiledata.contract.records import Finding
from tactiledata.errors import TactileDataError
from tactiledata.store.reader import Store


def split_findings(store: Store) -> Iterator[Finding]:
    """Tables of splits that are missing or changed, and tables that no document vouches for."""
    files = store.names("splits")
    vouched = set()
    for name in files:
        if not name.endswith(".json"):
            continue
        try:
            document = json.loads(store.read_file(f"splits/{name}"))
            table = document["table"] if str(document["format"]).startswith("tactiledata-split/") else None
            vouched |= {table["file"]} if table else set()
            fault = _table_fault(store, files, table["file"], table["sha256"]) if table else ""
        except (ValueError, TypeError, KeyError, RecursionError, TactileDataError):
            fault = f"splits/{name} cannot be read"
        if fault:
            yield Finding("store-split", "damage", f"{fault}; take it from a copy, or draw the split anew", stream=name)
    for name in files:
        if name.endswith(".parquet") and name not in vouched:
            message = f"splits/{name} has no document that vouches for it; draw the split anew"
            yield Finding("store-split", "damage", message, stream=name)


def _table_fault(store: Store, files: list[str], file: str, sha256: str) -> str:
    if file not in files:
        return f"splits/{file} is missing"
    if hashlib.sha256(store.read_file(f"splits/{file}")).hexdigest() != sha256:
        return f"splits/{file} is not the table that its document names"
    return ""
