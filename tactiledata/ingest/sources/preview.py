"""What ingest would make of a recording and say of it, without a store and without decoding its pictures."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Recording, Source
from tactiledata.contract.take import FrameFlag, Take, findings_of
from tactiledata.errors import TactileDataError
from tactiledata.formats import FORMATS
from tactiledata.formats.base import Inspection
from tactiledata.formats.reading.intake import MOST_OPENED
from tactiledata.ingest.checks.camera_names import camera_findings, cameras_of_takes
from tactiledata.ingest.checks.checks import broken_finding, check_take, flag_images, stated_size_findings
from tactiledata.ingest.checks.twins import overlaps, twin_finding
from tactiledata.ingest.sources.image_facts import ImageFacts
from tactiledata.ingest.sources.refused import refusals_told
from tactiledata.ingest.trajectories.assemble import IngestOptions, assemble
from tactiledata.store.layout.sensors_table import Facts, merged_facts, reference_conflict

NAMELESS = "<digest>"
"""Stands for the digest of the files, which only ingest computes, in names of sensors that nobody names."""

NOT_CHECKED = (
    "Only ingest decodes pictures: it alone finds blank ones, swapped channels, a touch in a picture without contact, "
    f"and the camera's lag. Of files of images inspect opens the first {MOST_OPENED} of each camera. What the store "
    "holds already is compared at ingest, too."
)
"""Which checks are not made here, for people."""

SIGNAL_MEANING = ("columns", "units", "frame")
"""What must be the same for signals of two recordings to be kept as one."""


@dataclass(frozen=True)
class Preview:
    """What a recording holds, and what ingest would make of it.

    Parameters
    ----------
    inspection : Inspection
        With the findings of ingest behind those of the format.
    take : Take, optional
        What would be kept; ``None`` where ingest would refuse the recording, or the format does not tell.
    """

    inspection: Inspection
    take: Take | None = None

    @property
    def status(self) -> str:
        """Status that the recording would have, as far as it can be told here; empty without a take."""
        if self.take is None:
            return ""
        is_damaged = any(finding.severity == "damage" for finding in self.inspection.findings)
        return "damaged" if is_damaged else self.take.status

    def with_findings(self, findings: Sequence[Finding]) -> Preview:
        """The preview with more findings; those that it has are not repeated."""
        known = self.inspection.findings
        said = (*known, *(finding for finding in findings if finding not in known))
        return dataclasses.replace(self, inspection=dataclasses.replace(self.inspection, findings=said))


def preview(source: Source, mapping: Mapping[str, Any] | None = None) -> Preview:
    """What a source holds, and what ingest would make of it and say of it.

    Parameters
    ----------
    source : Source
        One that `find_sources` found.
    mapping : dict, optional
        A document that fits ``schemas/mapping.json``.

    Raises
    ------
    TactileDataError
        Nothing can be read.
    """
    facts = ImageFacts()
    with refusals_told(source):
        inspection = FORMATS[source.format]().inspect(source, mapping, facts)
    if inspection.recording is None:
        return Preview(inspection)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # as ingest does
            take, findings = _take(inspection.recording, facts, IngestOptions(mapping=mapping))
    except TactileDataError as error:
        refusal = Finding("would-not-be-read", "warning", f"ingest would not read it: {error}")
        return Preview(inspection).with_findings([refusal])
    return Preview(inspection, take).with_findings(findings)


def _take(recording: Recording, facts: ImageFacts, options: IngestOptions) -> tuple[Take, list[Finding]]:
    """The take of a recording whose images were not decoded, and all that is said of it."""
    said: list[Finding] = []
    if facts.cut and not any(finding.code == "image-truncated" for finding in recording.findings):
        said.append(broken_finding(len(facts.cut)))
    assembled = assemble(recording, facts.table(), _stand_ins, NAMELESS, options)
    frames = flag_images(assembled.take.frames, assembled.order, np.array(facts.cut, np.int64), FrameFlag.BROKEN)
    take = dataclasses.replace(assembled.take, frames=frames)
    return take, [*findings_of(take.findings), *said, *check_take(take, _nothing), *stated_size_findings(take)]


def _stand_ins(rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
    """A pixel for each image: whether a sensor has enough frames in free air does not depend on what they show."""
    return [np.zeros((1, 1, 3), np.uint8)] * len(rows)


def _nothing(rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
    """No picture for the checks that look at pictures: they say nothing."""
    return [None] * len(rows)


def compared(previews: Sequence[Preview]) -> list[Preview]:
    """The previews, each with what its recording contradicts in those before it, and what it is beside all others."""
    touches = [
        {**touch, "source": row}
        for row, item in enumerate(previews)
        if item.take is not None
        for touch in item.take.trajectories.select(["sensor", "start_ns", "end_ns", "parent"]).to_pylist()
    ]
    pairs = overlaps(touches)
    keys = [item.inspection.source.key for item in previews]
    cameras = camera_findings(keys, cameras_of_takes([item.take for item in previews]))
    known = _Known()
    return [
        item.with_findings(
            [
                *(known.conflicts(item) if item.take is not None else ()),
                *([cameras[row]] if row in cameras else []),
                *([twin_finding(keys, pairs[row])] if row in pairs else []),
            ]
        )
        for row, item in enumerate(previews)
    ]


class _Known:
    """What the recordings so far state of sensors and signals."""

    def __init__(self) -> None:
        self._facts: Facts = {}
        self._pictures: dict[str, NDArray[np.uint8]] = {}
        self._signals: dict[str, dict[str, Any]] = {}

    def conflicts(self, item: Preview) -> list[Finding]:
        """Findings on what a recording states otherwise than those before it, which are known from now on."""
        take, recording = item.take, item.inspection.recording
        assert take is not None
        assert recording is not None
        self._facts, found = merged_facts(self._facts, take.sensors)
        for sensor, picture in recording.references.items():
            conflict = reference_conflict(sensor, self._pictures.setdefault(sensor, picture), picture)
            found += [] if conflict is None else [conflict]
        for name, signal in sorted(take.signals.items()):
            meaning = {key: getattr(signal, key) for key in SIGNAL_MEANING}
            first = self._signals.setdefault(name, meaning)
            differing = [key for key in SIGNAL_MEANING if first[key] != meaning[key]]
            if differing:
                detail = "; ".join(f"{key} {meaning[key]!r} here, {first[key]!r} there" for key in differing)
                text = f"signal {name!r} means something else than in a recording before ({detail}); it is kept apart"
                found.append(Finding("signal-variant", "warning", text, stream=name))
        return found
