"""What became of the recordings that an ingest was given."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tactiledata.contract.records import Finding
from tactiledata.contract.simulated import Kind, SimulatedCount, recording_kind
from tactiledata.contract.take import findings_of
from tactiledata.formats.mcap.passed_over import TOPIC_LEFT
from tactiledata.store.write.writer import StagedTake


def status_in_words(status: str, findings: Iterable[Finding]) -> str:
    """The status of a recording, with the streams that topics of it could be and that are not read.

    Examples
    --------
    >>> status_in_words("ok", [Finding(TOPIC_LEFT, "warning", "nothing is read as wrench", "wrench")])
    'ok, but wrench not read'
    """
    left = list(dict.fromkeys(finding.stream for finding in findings if finding.code == TOPIC_LEFT))
    return f"{status}, but {', '.join(left)} not read" if status and left else status


@dataclass(frozen=True)
class SourceReport:
    """What became of one source.

    Parameters
    ----------
    key : str
    state : "added", "replaced", "present" or "failed"
        ``present``: the store had it already, or a copy of it came in before it.
    status : str
        ``ok``, ``unverified``, ``damaged``; empty where it failed.
    frames, trajectories : int
    findings : tuple of Finding
    error : str
        Why it failed.
    sha256 : str
        Digest of its files; empty where it failed.
    kind : "simulated", "real" or "not stated"
        What its description states of its contacts.
    copy_of : str
        Key of the source of the same call whose files are the same and which came in; empty where there is none.
    name : str
        What the store's commands call it, where several of its recordings have the key; empty where the key does.
    """

    key: str
    state: str
    status: str = ""
    frames: int = 0
    trajectories: int = 0
    findings: tuple[Finding, ...] = ()
    error: str = ""
    sha256: str = ""
    kind: Kind = "not stated"
    copy_of: str = ""
    name: str = ""

    @property
    def words(self) -> str:
        """Its name for people."""
        return self.name or self.key


@dataclass(frozen=True)
class IngestReport:
    """What became of all sources of a call.

    Parameters
    ----------
    store : str
    sources : tuple of SourceReport
    unclaimed : tuple of str
        Files that no format claims.
    findings : tuple of Finding
        What concerns no one source.
    stale_splits : tuple of str
        Splits of the store, if it changed, that do not know all its trajectories.
    """

    store: str
    sources: tuple[SourceReport, ...]
    unclaimed: tuple[str, ...]
    findings: tuple[Finding, ...] = ()
    stale_splits: tuple[str, ...] = ()

    @property
    def changed(self) -> bool:
        """Whether the store is another than before."""
        return any(source.state in ("added", "replaced") for source in self.sources)

    @property
    def simulated(self) -> SimulatedCount:
        """How many of the recordings that came in are simulated."""
        return SimulatedCount.of(source.kind for source in self.sources if source.state in ("added", "replaced"))

    @property
    def fell_short(self) -> bool:
        """Whether a source failed or lost data, or a place could not be read."""
        is_short = any(source.state == "failed" or source.status == "damaged" for source in self.sources)
        return is_short or any(finding.severity == "damage" for finding in self.findings)

    def document(self) -> dict[str, Any]:
        """The report as JSON values."""
        return {
            "store": self.store,
            "sources": [
                {
                    "key": source.key,
                    "name": source.name or source.key,
                    "state": source.state,
                    "status": source.status,
                    "frames": source.frames,
                    "trajectories": source.trajectories,
                    "kind": source.kind,
                    "copy_of": source.copy_of,
                    "error": source.error,
                    "findings": [vars(finding) for finding in source.findings],
                }
                for source in self.sources
            ],
            "unclaimed": list(self.unclaimed),
            "findings": [vars(finding) for finding in self.findings],
            "stale_splits": list(self.stale_splits),
            "fell_short": self.fell_short,
            "simulated_recordings": self.simulated.document(),
        }


def with_copies(reports: Sequence[SourceReport]) -> list[SourceReport]:
    """Return the reports, where those of copies name the source of the same call that came in.

    Parameters
    ----------
    reports : sequence of SourceReport
        Of all sources of one call.
    """
    came = {report.sha256: report.key for report in reports if report.state in ("added", "replaced")}
    return [
        replace(report, copy_of=came[report.sha256]) if report.state == "present" and report.sha256 in came else report
        for report in reports
    ]


def report_of(key: str, state: str, staged: StagedTake, *findings: Finding) -> SourceReport:
    """Return the report of a source that was read and staged.

    Parameters
    ----------
    key : str
        Name of the source.
    state : "added", "replaced" or "present"
        What became of it.
    staged : StagedTake
        The source as it waits for its commit.
    *findings : Finding
        Further findings, after those of the take.
    """
    return SourceReport(
        key,
        state,
        staged.document["status"],
        staged.n_frames,
        staged.table("trajectories").num_rows,
        (*findings_of(staged.table("findings")), *findings),
        sha256=staged.sha256,
        kind=recording_kind(staged.document["description"]),
    )
