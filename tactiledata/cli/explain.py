"""Reporting of failures inside a damaged store: as damage, not as a fault of the program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tactiledata.errors import StoreError, TactileDataError


@contextmanager
def damage_explains(location: str) -> Iterator[None]:
    """Check the store where the block fails unexpectedly, and raise its damage, if any, as the error.

    Where the store is whole, the failure is a fault of ours and is raised as it is.
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
    """Return the message of the first damage in a store; empty where it is whole."""
    from tactiledata.store.check.check import check

    try:
        damages = [finding for finding in check(location, images=False) if finding.severity == "damage"]
    except TactileDataError as error:
        return str(error)
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        return f"its tables cannot even be checked ({type(error).__name__}: {error})"
    return damages[0].message if damages else ""
