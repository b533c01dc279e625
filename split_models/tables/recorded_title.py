"""Titles of a store's own pictures beside those that methods make."""

from __future__ import annotations

from pathlib import Path

from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings


def recorded_title(store: str | Path) -> str:
    """Title of a column with a store's own pictures: ``"recorded"``, or a label that marks simulated recordings."""
    return simulated_recordings(Store.open(store)).label or "recorded"


def recorded_row(store: str | Path) -> str:
    """Title of a row with a store's own pictures; the paper's ``Real`` only where all recordings state to be real."""
    count = simulated_recordings(Store.open(store))
    if count.total and count.real == count.total:
        return "as recorded (Real)"
    return count.titled("as recorded")
