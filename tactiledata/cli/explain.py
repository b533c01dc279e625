"""A failure inside a damaged store is told as what it is: damage, not a fault of the program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tactiledata.errors import StoreError, TactileDataError


@contextmanager
def damage_explains(location: str) -> Iterator[None]:
    """Where the block fails unexpectedly, the store is checked; its damage, if any, becomes the error.

    A store that checks as whole leaves the failure as it is: then it is ours.
    """
    try:
        yield
    except (TactileDataError, OSError):
        raise
    except Exception as error:
        damage = _first_damage(location)
        if not damage:
            raise
        raise StoreError(
            f"the store {location} is damaged: {damage}",
            "the files that its manifest names",
            "`tactiledata check` lists all damage; restore those files from a copy, or ingest the recordings anew.",
        ) from error


def _first_damage(location: str) -> str:
    from tactiledata.store.check.check import check

    try:
        found = [finding for finding in check(location, images=False) if finding.severity == "damage"]
    except TactileDataError as error:
        return str(error)
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        return f"its tables cannot even be checked ({type(error).__name__}: {error})"
    return found[0].message if found else ""
