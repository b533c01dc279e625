"""What recordings of a store are only beside each other: copies of one another, cameras that others call otherwise.

Nothing of it is kept: the next recording, or one that is put in the place of another, changes it.
"""

from __future__ import annotations

from tactiledata.contract.records import Finding
from tactiledata.contract.take import findings_of
from tactiledata.ingest.checks.camera_names import camera_findings, cameras_of_store
from tactiledata.ingest.checks.twins import twins_of_store
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names


def findings_beside(store: Store) -> dict[int, tuple[Finding, ...]]:
    """The findings on recordings that only the others of the store tell, by row of the table of sources."""
    named, twins = camera_findings(recording_names(store), cameras_of_store(store)), twins_of_store(store)
    return {row: tuple(found[row] for found in (named, twins) if row in found) for row in sorted({*named, *twins})}


def all_findings(store: Store) -> list[tuple[int, Finding]]:
    """Every finding of a store, each behind the row of its recording: those it keeps, then those found now."""
    table = store.findings()
    kept = zip(table["source"].to_pylist(), findings_of(table), strict=True)
    return [*kept, *((row, finding) for row, found in findings_beside(store).items() for finding in found)]
