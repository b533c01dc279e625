"""Whether the flags of a store's trajectories are those that were written."""

from __future__ import annotations

from collections.abc import Iterator

from tactiledata.contract.records import Finding
from tactiledata.errors import LostFile, NotFetched, SchemaError, StoreError
from tactiledata.store.layout.places import FLAGS
from tactiledata.store.read.flags import stored_flags
from tactiledata.store.read.reader import Store


def flags_findings(store: Store) -> Iterator[Finding]:
    """Damage of the file of flags; a store that never had flags has no such file."""
    try:
        stored_flags(store)
    except NotFetched:  # said by what looks for pointers
        return
    except (SchemaError, StoreError, LostFile) as error:
        yield Finding("store-flags", "damage", str(error), stream=FLAGS)
