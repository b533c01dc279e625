"""Numbers of a group of takes on their way into a store: signals at native rate, and values that have a row a frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray

from tactiledata.contract.provenance import digest_of
from tactiledata.contract.records import Finding
from tactiledata.store.layout.arrays import append_rows, create_rows, set_length
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest, settings_of
from tactiledata.store.layout.places import (
    ALIGNED_ARRAYS,
    SIGNAL_ARRAYS,
    aligned_path,
    frame_values_path,
    home_of,
    signal_path,
)
from tactiledata.store.layout.statistics import added, no_statistics
from tactiledata.store.write.writer import StagedTake

KINDS = ("signals", "aligned", "frame_values")
KIND_WORDS = {"signals": "signal", "aligned": "aligned value", "frame_values": "frame value"}
"""What one of each kind is called in a message."""
MEANING = ("columns", "units", "frame")
BLOCK_ROWS = 65_536

Entry = Mapping[str, Any]
Noted = list[tuple[int, StagedTake, Entry]]
"""First frame of a take in the store, the take, and its entry for the value."""


class ValueAppender:
    """Notes the values of takes one by one, then appends them array by array, so that each chunk is written once.

    Parameters
    ----------
    batch : Batch
    root : zarr.Group
        The store's group, to create arrays in.
    manifest : dict
        Changed in place.
    """

    def __init__(self, batch: Batch, root: zarr.Group, manifest: Manifest) -> None:
        self._batch, self._root, self._manifest = batch, root, manifest
        self._home = home_of(manifest)
        self._chunk_rows = settings_of(manifest).signal_chunk_rows
        self._first_frame: int = manifest["rows"]["frames"]
        self._first_rows = {name: facts["rows"] for name, facts in manifest["signals"].items()}
        self._known = {(kind, name) for kind in KINDS for name in manifest[kind]}
        self._noted: dict[tuple[str, str], Noted] = {}

    def add(self, take: StagedTake) -> tuple[dict[str, Any], dict[str, str], list[Finding]]:
        """One take; what the sources table keeps of its values, the names that its signals got, and findings."""
        contents: dict[str, Any] = {}
        names: dict[str, str] = {}
        findings: dict[str, Finding] = {}
        for kind in KINDS:
            contents[kind] = {}
            for name, entry in take.document[kind].items():
                stored = self._stored_name(kind, name, entry)
                if stored != name:
                    # values of the same name that were made of a signal differ as it does: said once
                    findings.setdefault(name, self._variant_finding(kind, name, stored, entry))
                if kind == "signals":
                    names[name] = stored
                contents[kind][stored] = {"name": name, **self._note(kind, stored, take, entry)}
        return contents, names, list(findings.values())

    def finish(self) -> None:
        """All values written."""
        for (kind, name), noted in self._noted.items():
            if kind == "signals":
                self._finish_signal(name, noted)
        for kind, arrays in (("aligned", ALIGNED_ARRAYS), ("frame_values", ("value",))):
            for name in self._manifest[kind]:
                self._finish_frame_rows(kind, name, arrays)

    def _fits(self, kind: str, stored: str, entry: Entry) -> bool:
        known = self._manifest[kind].get(stored)
        return known is None or all(known[key] == entry[key] for key in MEANING)

    def _stored_name(self, kind: str, name: str, entry: Entry) -> str:
        """The name under which values are kept: their own, or another where that means something else."""
        if self._fits(kind, name, entry):
            return name
        by_frame = f"{name}@{entry['frame']}"
        if self._manifest[kind][name]["frame"] != entry["frame"] and self._fits(kind, by_frame, entry):
            return by_frame
        return f"{name}@{digest_of({key: entry[key] for key in MEANING})[:8]}"

    def _variant_finding(self, kind: str, name: str, stored: str, entry: Entry) -> Finding:
        known = self._manifest[kind][name]
        differing = [key for key in MEANING if known[key] != entry[key]]
        detail = "; ".join(f"{key} {entry[key]!r} here, {known[key]!r} in the store" for key in differing)
        message = (
            f"{KIND_WORDS[kind]} {name!r} means something else than in the store ({detail}); kept apart as {stored!r}. "
            f"Ask for both names when loading; or mend the mapping, and ingest with --replace"
        )
        return Finding("signal-variant", "warning", message, stream=name)

    def _note(self, kind: str, stored: str, take: StagedTake, entry: Entry) -> dict[str, Any]:
        first = {
            "rows": 0 if kind == "signals" else self._first_frame,
            **{key: entry[key] for key in (*MEANING, "attributes")},
            "statistics": no_statistics(len(entry["columns"])),
        }
        facts = self._manifest[kind].setdefault(stored, first)
        self._noted.setdefault((kind, stored), []).append((self._manifest["rows"]["frames"], take, entry))
        noted: dict[str, Any] = {"crc32c": {array: place["crc32c"] for array, place in entry["arrays"].items()}}
        noted["attributes"] = entry["attributes"]
        if kind == "signals":
            start = facts["rows"]
            facts["rows"] += entry["arrays"]["t_ns"]["shape"][0]
            noted["rows"] = [start, facts["rows"]]
        return noted

    def _finish_signal(self, name: str, noted: Noted) -> None:
        facts = self._manifest["signals"][name]
        start = self._first_rows.get(name, 0)
        for array in SIGNAL_ARRAYS:
            path = signal_path(self._home, name, array)
            if start == 0:
                self._create(path, array, facts)
            blocks = (take.array(entry["arrays"][array]) for _, take, entry in noted)
            append_rows(self._batch, path, start, facts["rows"], blocks)
        _count(facts, noted)

    def _finish_frame_rows(self, kind: str, name: str, arrays: tuple[str, ...]) -> None:
        """Every array gets a row a frame, also where takes of this group have no such value."""
        start, stop = self._first_frame, self._manifest["rows"]["frames"]
        facts = self._manifest[kind][name]
        noted = self._noted.get((kind, name), [])
        for array in arrays:
            path = aligned_path(self._home, name, array) if kind == "aligned" else frame_values_path(self._home, name)
            if (kind, name) not in self._known:
                self._create(path, array, facts)
            if noted:
                width = len(facts["columns"]) if array == "value" else None
                append_rows(self._batch, path, start, stop, _filled(noted, array, width, start, stop))
            else:
                set_length(self._batch, path, stop)
        facts["rows"] = stop
        _count(facts, noted)

    def _create(self, path: str, array: str, facts: Entry) -> None:
        if array == "value":
            described = {key: facts[key] for key in (*MEANING, "attributes")}
            create_rows(self._root, path, len(facts["columns"]), "<f8", np.nan, self._chunk_rows, described)
        else:
            create_rows(self._root, path, None, "<i8", -1, self._chunk_rows, {"unit": "ns"})


def _filled(noted: Noted, array: str, width: int | None, start: int, stop: int) -> Iterator[NDArray[Any]]:
    """Blocks of rows [start, stop): those of the takes that have the value, and fill between them."""

    def nothing(count: int) -> Iterator[NDArray[Any]]:
        for first in range(0, count, BLOCK_ROWS):
            rows = min(BLOCK_ROWS, count - first)
            yield np.full(rows, -1, np.int64) if width is None else np.full((rows, width), np.nan)

    row = start
    for first, take, entry in noted:
        yield from nothing(first - row)
        values = take.array(entry["arrays"][array])
        yield values
        row = first + len(values)
    yield from nothing(stop - row)


def _count(facts: dict[str, Any], noted: Noted) -> None:
    for _, take, entry in noted:
        values = take.array(entry["arrays"]["value"])
        for start in range(0, len(values), BLOCK_ROWS):
            facts["statistics"] = added(facts["statistics"], np.asarray(values[start : start + BLOCK_ROWS]))
