"""Recordings into a store: found, read by workers, committed in order; safe to kill and to run again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.compute import SCHEDULERS
from tactiledata.compute.base import Outcome
from tactiledata.contract.provenance import digest_of, file_digest, files_digest
from tactiledata.contract.records import Finding, Recording, Source
from tactiledata.contract.schema import check_document
from tactiledata.contract.take import Take, findings_of, findings_table
from tactiledata.errors import BrokenLog, MissingFile
from tactiledata.formats import FORMATS
from tactiledata.ingest.assemble import IngestOptions, assemble
from tactiledata.ingest.checks import broken_images, check_take, flag_broken
from tactiledata.ingest.discover import find_sources
from tactiledata.ingest.lag import camera_lag
from tactiledata.ingest.spooled import SpooledImages
from tactiledata.ingest.twins import twin_findings
from tactiledata.store.commit import commit_groups, create, recover
from tactiledata.store.layout import INTAKE_LOCK, staging_folder
from tactiledata.store.lock import writing_lock
from tactiledata.store.reader import Store
from tactiledata.store.spool import Spool
from tactiledata.store.writer import StagedTake, find_staged, stage

Progress = Callable[[int, int, str], None]
"""Called with how many sources are done, how many there are, and the name of the last one."""


@dataclass(frozen=True)
class SourceReport:
    """What became of one source.

    Parameters
    ----------
    key : str
    state : "added", "present" or "failed"
        ``present``: the store had it already.
    status : str
        ``ok``, ``unverified``, ``damaged``; empty where it failed.
    frames, trajectories : int
    findings : tuple of Finding
    error : str
        Why it failed.
    sha256 : str
        Digest of its files; empty where it failed.
    """

    key: str
    state: str
    status: str = ""
    frames: int = 0
    trajectories: int = 0
    findings: tuple[Finding, ...] = ()
    error: str = ""
    sha256: str = ""


@dataclass(frozen=True)
class IngestReport:
    """What became of all sources of a call, and the files that no format claims."""

    store: str
    sources: tuple[SourceReport, ...]
    unclaimed: tuple[str, ...]

    @property
    def fell_short(self) -> bool:
        """Whether a source failed or lost data."""
        return any(source.state == "failed" or source.status == "damaged" for source in self.sources)

    def document(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "store": self.store,
            "sources": [
                {
                    "key": source.key,
                    "state": source.state,
                    "status": source.status,
                    "frames": source.frames,
                    "trajectories": source.trajectories,
                    "error": source.error,
                    "findings": [vars(finding) for finding in source.findings],
                }
                for source in self.sources
            ],
            "unclaimed": list(self.unclaimed),
            "fell_short": self.fell_short,
        }


@dataclass(frozen=True)
class _Task:
    source: Source
    store: str
    options: IngestOptions
    present: frozenset[str]

    def __str__(self) -> str:
        return self.source.key


@dataclass(frozen=True)
class _Read:
    """What a worker returns: a staged take, or the word that the store has it already."""

    sha256: str
    staged: StagedTake | None


def ingest(
    paths: Sequence[str | Path],
    store: str | Path,
    options: IngestOptions | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> IngestReport:
    """Add recordings to a store, creating it where there is none.

    A source that the store has already (by the SHA-256 of its files) is left alone. A source that cannot be read is
    reported, and the others go on. Whatever moment the process is killed at, the same call goes on where it stopped.

    Parameters
    ----------
    paths : sequence of paths
        Recordings, or folders of recordings.
    store : path
        A local folder, by custom ending in ``.zarr``.
    options : IngestOptions, optional
    workers : int
        Local processes.
    scheduler : str, optional
        Address of a Dask scheduler, instead of local processes.
    progress : callable, optional

    Raises
    ------
    MissingFile, BrokenLog
        A path does not exist, or holds no recording at all.
    StoreError
        The store cannot be written.
    """
    chosen = options or IngestOptions()
    if chosen.mapping is not None:
        check_document(chosen.mapping, "mapping", "the mapping")
    sources, unclaimed = find_sources([Path(path) for path in paths], chosen.format_name)
    folder = Path(store)
    runner = SCHEDULERS["dask"](scheduler) if scheduler else SCHEDULERS["local"](workers)
    create(folder)
    reports: list[SourceReport] = []
    with writing_lock(folder, INTAKE_LOCK):
        present = frozenset(recover(folder)["sources"])
        tasks = [_Task(source, str(folder.resolve()), chosen, present) for source in sources]
        outcomes = runner.outcomes(_read_source, tasks)
        otherwise = _ingested_otherwise(folder, chosen)
        commit_groups(folder, _staged_takes(outcomes, set(present), otherwise, len(tasks), reports, progress))
    return IngestReport(str(store), _with_twins(reports, folder), tuple(str(path) for path in unclaimed))


def _with_twins(reports: list[SourceReport], folder: Path) -> tuple[SourceReport, ...]:
    """Reports, each with the word that its recording has a twin in the store, where it has one."""
    twins = twin_findings(Store.open(folder), [report.sha256 for report in reports])
    return tuple(
        replace(report, findings=(*report.findings, twins[report.sha256])) if report.sha256 in twins else report
        for report in reports
    )


def _staged_takes(
    outcomes: Iterator[Outcome[_Task, _Read]],
    seen: set[str],
    otherwise: set[str],
    n_tasks: int,
    reports: list[SourceReport],
    progress: Progress | None,
) -> Iterator[StagedTake]:
    """Takes that the store does not have yet, in order; every outcome is noted in ``reports``."""
    for outcome in outcomes:
        reports.append(_report(outcome, seen, otherwise))
        if progress is not None:
            progress(len(reports), n_tasks, outcome.task.source.key)
        if outcome.result is not None and outcome.result.staged is not None and outcome.result.sha256 not in seen:
            seen.add(outcome.result.sha256)
            yield outcome.result.staged


def _read_source(task: _Task) -> _Read:
    """One source, read, checked and staged; runs in a worker."""
    source, folder = task.source, Path(task.store)
    sha256 = source_digest(source)
    if sha256 in task.present:
        return _Read(sha256, None)
    waiting = find_staged(folder).get(sha256)
    if waiting is not None:
        return _Read(sha256, waiting)
    with Spool(staging_folder(folder, sha256)) as spool:
        recording = FORMATS[source.format]().read(source, spool, task.options.mapping)
        spool.close()
        images = SpooledImages(spool.folder, spool.columns())
        # numbers of 1e300 are no forces: they overflow to inf without a word, and `force-out-of-range` counts them
        with np.errstate(over="ignore", invalid="ignore"):
            take = _checked_take(recording, images, sha256, task.options)
        if task.options.strict:
            _refuse_damage(take, source)
        return _Read(sha256, stage(folder, spool, take))


def _checked_take(recording: Recording, images: SpooledImages, sha256: str, options: IngestOptions) -> Take:
    """The take of a recording, with what the checks of its images found."""
    broken, cut = broken_images(images)
    known = {finding.code for finding in recording.findings}
    said = [finding for finding in cut if finding.code not in known]
    assembled = assemble(recording, images.columns, images.decode, sha256, options)
    take = replace(assembled.take, frames=flag_broken(assembled.take.frames, assembled.order, broken))

    def decode(rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
        return images.decode(assembled.order[rows])

    said = [*said, *check_take(take, decode), *camera_lag(take, decode)]
    findings = pa.concat_tables([take.findings, findings_table(said)])
    return replace(take, findings=findings, status=_worse(take.status, said))


def source_digest(source: Source) -> str:
    """SHA-256 of a source's contents, and of which part of them it is.

    One file is known by its content, whatever it is called; several files by their names below the source's folder and
    their contents.
    """
    root = Path(source.path)
    files = [Path(name) for name in source.files]
    for path in files:
        if not path.is_file():
            raise MissingFile(f"{path} of {source.key} vanished", "the file", "Was it moved while it was being read?")
    digest = file_digest(files[0]) if len(files) == 1 else files_digest(root if root.is_dir() else root.parent, files)
    return digest_of([digest, source.part]) if source.part else digest


def _worse(status: str, findings: list[Finding]) -> str:
    return "damaged" if any(finding.severity == "damage" for finding in findings) else status


def _refuse_damage(take: Take, source: Source) -> None:
    damage = [finding for finding in findings_of(take.findings) if finding.severity == "damage"]
    if damage:
        raise BrokenLog(
            f"{source.key} is damaged: {damage[0].message}" + (f" (and {len(damage) - 1} more)" if damage[1:] else ""),
            "an undamaged recording, because of --strict",
            "Leave --strict out to keep what is whole; the store then says what was lost.",
            key=source.key,
        )


def _ingested_otherwise(folder: Path, options: IngestOptions) -> set[str]:
    """Digests of the sources that the store took with another mapping or other options than these."""
    sources = Store.open(folder).sources(["sha256", "provenance"]).to_pylist()
    wanted = digest_of(options.document())
    return {row["sha256"] for row in sources if json.loads(row["provenance"]).get("settings_sha256") != wanted}


def _report(outcome: Outcome[_Task, _Read], seen: set[str], otherwise: set[str]) -> SourceReport:
    key = outcome.task.source.key
    if outcome.result is None:
        return SourceReport(key, "failed", error=str(outcome.error))
    staged = outcome.result.staged
    if staged is None or outcome.result.sha256 in seen:
        text = (
            "the store took it with another mapping or other options, and keeps that; into a new store it goes as asked"
        )
        other = Finding("ingested-otherwise", "warning", text)
        said = (other,) if outcome.result.sha256 in otherwise else ()
        return SourceReport(key, "present", findings=said, sha256=outcome.result.sha256)
    return SourceReport(
        key,
        "added",
        staged.document["status"],
        staged.n_frames,
        staged.table("trajectories").num_rows,
        findings_of(staged.table("findings")),
        sha256=outcome.result.sha256,
    )
