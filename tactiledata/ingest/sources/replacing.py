"""Which recording of a store a corrected one replaces, and the replacing."""

from __future__ import annotations

import json
import shutil
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.errors import StoreError, UnknownName
from tactiledata.ingest.checks.shared_images import image_words
from tactiledata.ingest.sources.reports import SourceReport, report_of
from tactiledata.store.change.replace import replace_takes
from tactiledata.store.check.payloads import payload_faults
from tactiledata.store.check.values import source_value_findings
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit_groups
from tactiledata.store.write.writer import StagedTake

IMAGE = ("height", "width", "crc32c", "encoding")
NOTHING = 0
"""CRC-32C of no bytes."""


class StoredRecordings:
    """The recordings of a store, to be recognised after they were corrected.

    A recording is the same where its files are the same; or where its name is the same (the name that ingest prints,
    which is an end of its path) and an image of the two is the same byte for byte, or the log stamps of a signal are.
    So an edited log.yaml, a calibration that was added or a file that was copied again stays the same recording, and
    two recordings that happen to be called alike do not. Of a name with folders the last part is enough, where one
    recording alone has it and is the same: ``monday/run1.mcap`` is ``run1.mcap`` where the file lies elsewhere now.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._sources = store.sources(["sha256", "key", "frames", "contents"]).to_pylist()
        self._contents = [json.loads(row["contents"]) for row in self._sources]

        self._same: dict[str, frozenset[int]] = {}

    @cached_property
    def _images(self) -> tuple[NDArray[np.uint64], NDArray[np.integer]]:
        """Numbers of all images, ascending, and the row of the source of each."""
        there, words = image_words(self._store.frames(["source", *IMAGE]))
        order = np.argsort(words, kind="stable")
        return words[order], there["source"].to_numpy()[order]

    def matches(self, staged: StagedTake, names: Collection[str] = ()) -> list[str]:
        """Digests of the sources that are the same recording as a staged one, which has other names, too."""
        key, alike = staged.document["key"], self._same_touches(staged)
        known = {key, *names}
        same = [
            source["sha256"]
            for row, source in enumerate(self._sources)
            if source["sha256"] == staged.sha256 or (source["key"] in known and row in alike)
        ]
        return same or self._of_last_part(PurePosixPath(key).name, staged)

    def _of_last_part(self, name: str, staged: StagedTake) -> list[str]:
        """Digest of the same recording under a name that ends in this part; nothing where several are, or none."""
        same = [
            source["sha256"]
            for row, source in enumerate(self._sources)
            if PurePosixPath(source["key"]).name == name and row in self._same_touches(staged)
        ]
        return same if len(same) == 1 else []

    def alike(self, staged: StagedTake) -> list[str]:
        """Names of the sources that hold an image or stamps of a staged recording, whatever they are called."""
        return [self._sources[row]["key"] for row in sorted(self._same_touches(staged))]

    def key(self, sha256: str) -> str:
        """The name of a source."""
        return next(source["key"] for source in self._sources if source["sha256"] == sha256)

    def is_exact(self, staged: StagedTake) -> bool:
        """Whether a source has the files, or the whole name, of a staged recording."""
        key, sha256 = staged.document["key"], staged.sha256
        return any(source["sha256"] == sha256 or source["key"] == key for source in self._sources)

    def holds(self, staged: StagedTake) -> bool:
        """Whether the store has this take already, as it is and undamaged."""
        store, first = self._store, 0
        for source, contents in zip(self._sources, self._contents, strict=True):
            rows = range(first, first + source["frames"])
            first = rows.stop
            if source["sha256"] == staged.sha256:
                return (
                    contents["content"] == staged.document["content"]
                    and self._holds_pictures(staged)
                    and not list(payload_faults(store, rows=rows))
                    and not list(
                        source_value_findings(store, source["key"], source["contents"], (first - len(rows), first))
                    )
                )
        return False

    def _holds_pictures(self, staged: StagedTake) -> bool:
        """Whether each sensor that comes with a picture without contact has one here that can be read."""
        try:
            for sensor in staged.document["references"]:
                self._store.reference(sensor)
        except (UnknownName, StoreError):
            return False
        return True

    def _same_touches(self, staged: StagedTake) -> frozenset[int]:
        """Rows of the sources that hold an image or the log stamps of a signal of a staged take; looked up once."""
        if staged.sha256 not in self._same:
            stamps = {entry["arrays"]["log_ns"]["crc32c"] for entry in staged.document["signals"].values()} - {NOTHING}
            rows = {
                row
                for row, contents in enumerate(self._contents)
                if any(facts["crc32c"]["log_ns"] in stamps for facts in contents["signals"].values())
            }
            words, source = self._images
            wanted = np.unique(image_words(staged.table("frames"))[1])
            for first, stop in zip(*(np.searchsorted(words, wanted, side) for side in ("left", "right")), strict=True):
                rows.update(source[first:stop].tolist())
            self._same[staged.sha256] = frozenset(rows)
        return self._same[staged.sha256]


@dataclass(frozen=True)
class Plan:
    """What becomes of staged takes: replacements by the digest of what goes, new ones, and those that are held."""

    replacements: dict[str, StagedTake | None]
    new: list[StagedTake]
    held: list[StagedTake]

    def state(self, staged: StagedTake) -> str:
        """``replaced``, ``added`` or ``present``."""
        if any(staged is one for one in self.replacements.values()):
            return "replaced"
        return "added" if any(staged is one for one in self.new) else "present"


def plan(
    stored: StoredRecordings, takes: Sequence[StagedTake], names: Mapping[str, Collection[str]] = MappingProxyType({})
) -> Plan:
    """Each recording of the store is replaced once, by the take with the same files before one with the same name.

    Parameters
    ----------
    stored : StoredRecordings
    takes : sequence of StagedTake
    names : mapping, key -> collection of str
        What else a take may be called in the store.
    """
    chosen = Plan({}, [], [])
    taken: set[str] = set()
    found = [(take, stored.matches(take, names.get(take.document["key"], ()))) for take in takes]
    for take, matches in sorted(found, key=lambda one: (one[0].sha256 not in one[1], not stored.is_exact(one[0]))):
        if take.sha256 in taken:
            chosen.held.append(take)
            continue
        old = [sha256 for sha256 in matches if sha256 not in taken]
        taken |= {take.sha256, *old}
        if old == [take.sha256] and stored.holds(take):
            chosen.held.append(take)
        elif old:
            chosen.replacements.update({old[0]: take, **dict.fromkeys(old[1:])})
        else:
            chosen.new.append(take)
    return chosen


def replace_recordings(
    folder: Path,
    read: Iterable[tuple[str, StagedTake | None, str]],
    names: Mapping[str, Collection[str]] = MappingProxyType({}),
) -> tuple[list[SourceReport], list[Finding]]:
    """Reports of all sources, and what concerns none of them, after recordings were put in the place of older ones.

    Parameters
    ----------
    folder : Path
        The store.
    read : iterable of (key, staged take, error)
        All are staged before any is committed: which replaces which is known only then.
    names : mapping, key -> collection of str
        What else each may be called in the store.
    """
    outcomes = list(read)
    takes = [staged for _, staged, _ in outcomes if staged is not None]
    stored = StoredRecordings(Store.open(folder))
    chosen = plan(stored, takes, names)
    reports = [_report(key, staged, error, chosen, stored) for key, staged, error in outcomes]
    # what comes in the place of another keeps its name: flags and commands go by it
    replacements = {sha256: take and take.renamed(stored.key(sha256)) for sha256, take in chosen.replacements.items()}
    findings = replace_takes(folder, replacements) if replacements else []
    new = {take.sha256: take for take in chosen.new}
    commit_groups(folder, new.values())
    for take in chosen.held:
        shutil.rmtree(take.folder, ignore_errors=True)
    return reports, findings


def _report(key: str, staged: StagedTake | None, error: str, chosen: Plan, stored: StoredRecordings) -> SourceReport:
    if staged is None:
        return SourceReport(key, "failed", error=error)
    state = chosen.state(staged)
    if state == "present":
        return SourceReport(key, state, sha256=staged.sha256)
    if state == "replaced":
        return report_of(key, state, staged)
    text = "nothing in the store is this recording (same files, or same name and an image or signal in common); added"
    if alike := stored.alike(staged):
        text += (
            f". {alike[0]} holds images or times of it: to put this one in its place, give it the name"
            f" {PurePosixPath(alike[0]).name}, and ingest it with --replace again"
        )
    return report_of(key, state, staged, Finding("nothing-replaced", "info", text))
