"""Whether the tables of a store are the files that its manifest names, and can be used to check the rest."""

from __future__ import annotations

from collections.abc import Iterator

from tactiledata.contract.lfs_pointer import without_remedy
from tactiledata.contract.provenance import bytes_digest
from tactiledata.contract.records import Finding
from tactiledata.errors import TactileDataError
from tactiledata.store.layout.places import TABLE_SCHEMAS, TABLES, table_folder
from tactiledata.store.read.reader import Store

MAY_BE_NULL = {"findings": ("start_ns", "end_ns")}


def table_findings(store: Store) -> dict[str, list[Finding]]:
    """What is wrong with each table; those where nothing is can be used."""
    found = {}
    for table in TABLES:
        found[table] = list(_part_findings(store, table))
        if not found[table]:
            found[table] = list(_content_findings(store, table))
    return found


def _part_findings(store: Store, table: str) -> Iterator[Finding]:
    for part in store.manifest["index"][table]:
        path = f"{table_folder(table)}/{part['file']}"
        try:
            digest = bytes_digest(store.read_file(path))
        except (TactileDataError, OSError) as error:
            yield Finding("store-part", "damage", f"{path} cannot be read: {without_remedy(error)}", stream=table)
            continue
        if digest != part["sha256"]:
            message = f"{path} is not the file that the manifest names (SHA-256 {digest[:12]}…)"
            yield Finding("store-part", "damage", message, stream=table)


def _content_findings(store: Store, table: str) -> Iterator[Finding]:
    """Files that were written wrong: another schema, or rows without a value."""
    try:
        rows = store.table(table)
    except TactileDataError as error:
        yield Finding("store-part", "damage", without_remedy(error), stream=table)
        return
    for name in TABLE_SCHEMAS[table].names:
        empty = rows[name].null_count
        if empty and name not in MAY_BE_NULL.get(table, ()):
            message = f"the column {name!r} of the table {table} has no value in {empty} rows"
            yield Finding("store-index", "damage", message, stream=table, count=empty)


def not_checked(broken: set[str], checks: dict[str, tuple[str, ...]]) -> Iterator[Finding]:
    """A finding for what could not be checked because tables are broken.

    Parameters
    ----------
    checks : dict
        Of each check, in words, the tables that it needs.
    """
    left = [what for what, tables in checks.items() if broken & set(tables)]
    if left:
        message = f"because of {' and '.join(sorted(broken))} it could not be checked {'; nor '.join(left)}"
        yield Finding("store-not-checked", "warning", message, count=len(left))
