"""Whether the files of the splits in a store are those that were written."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from tactiledata.contract.provenance import bytes_digest
from tactiledata.contract.records import Finding
from tactiledata.contract.schema import check_document
from tactiledata.contract.sealed import SEAL, fits_seal
from tactiledata.contract.wording import counted
from tactiledata.errors import MissingFile, NotFetched, SchemaError, StoreError, TactileDataError
from tactiledata.store.layout.made_splits import made_names
from tactiledata.store.layout.places import MADE_SPLITS
from tactiledata.store.read.reader import Store


def split_findings(store: Store) -> Iterator[Finding]:
    """Splits that are gone or whose files were changed, and tables that no document vouches for."""
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
            yield Finding("store-split", "damage", error.found, stream=name)
            continue
        except StoreError as error:  # of the document or of its table, which it names
            fault = f"splits/{name} cannot be checked: {error.found}"
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
    yield from _gone(store, files)


def _gone(store: Store, files: list[str]) -> Iterator[Finding]:
    """Splits that were made of the store and have no file any more; and a list of splits that cannot be read."""
    try:
        made = made_names(store.read_file(MADE_SPLITS))
    except MissingFile:  # no split yet, or made before there was a list
        return
    except NotFetched:  # said by what looks for pointers
        return
    except (SchemaError, StoreError) as error:
        yield Finding("store-split", "damage", str(error), stream=MADE_SPLITS)
        return
    gone = [name for name in made if not {f"{name}.json", f"{name}.parquet"} & set(files)]
    if gone:
        message = (
            f"{counted(len(gone), 'split')} that {'was' if len(gone) == 1 else 'were'} made of the store "
            f"{'is' if len(gone) == 1 else 'are'} gone, table and document: {', '.join(gone)}; take the files from a "
            "copy, or draw the split anew with the same options. If it was taken out on purpose, `check --repair` "
            "takes it off the list"
        )
        yield Finding("store-split-gone", "warning", message, stream=MADE_SPLITS, count=len(gone))


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
