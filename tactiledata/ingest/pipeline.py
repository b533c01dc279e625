"""Recordings into a store: found, read by workers, committed in order; safe to kill and to run again."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.compute import make_scheduler
from tactiledata.compute.base import Outcome
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.provenance import digest_of, file_digest, files_digest
from tactiledata.contract.records import Finding, Recording, Source
from tactiledata.contract.schema import check_document
from tactiledata.contract.take import FrameFlag, Take, findings_of, findings_table
from tactiledata.errors import BrokenLog, MissingFile, StoreError
from tactiledata.formats import FORMATS
from tactiledata.ingest.checks.beside import findings_beside
from tactiledata.ingest.checks.blank_images import blank_images
from tactiledata.ingest.checks.checks import broken_images, check_take, flag_images
from tactiledata.ingest.checks.conflicts import conflict_findings
from tactiledata.ingest.checks.spooled import SpooledImages
from tactiledata.ingest.clocks.lag import camera_lag
from tactiledata.ingest.sources.discover import find_sources, named_apart, path_ends, unclaimed_findings
from tactiledata.ingest.sources.refused import refusals_told
from tactiledata.ingest.sources.replacing import replace_recordings
from tactiledata.ingest.sources.reports import IngestReport, SourceReport, report_of, with_copies
from tactiledata.ingest.trajectories.assemble import IngestOptions, assemble
from tactiledata.splits.manifest import unusable_splits
from tactiledata.store.check.lost_files import need_tables
from tactiledata.store.layout.lock import reading_lock
from tactiledata.store.layout.manifest import read_manifest
from tactiledata.store.layout.places import staging_folder
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names
from tactiledata.store.write.commit import commit_groups, recover
from tactiledata.store.write.intake import intake
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import StagedTake, find_staged, stage


@dataclass(frozen=True)
class _Task:
    """A source to be read, and its key in the store if it is new there."""

    source: Source
    key: str
    store: str
    options: IngestOptions
    present: frozenset[str]
    replace: bool

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
    replace: bool = False,
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
    replace : bool
        Read also what the store has already, and put it in the place of what the store holds of the same recording:
        see `tactiledata.ingest.sources.replacing.StoredRecordings`.

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
    if scheduler is not None:
        sources = [source.absolute() for source in sources]  # workers of a cluster were started in other folders
    folder = Path(store)
    runner = make_scheduler(workers, scheduler)
    with intake(folder):
        present = frozenset(recover(folder)["sources"])
        opened = Store.open(folder)
        need_tables(opened)
        taken = () if replace else opened.sources(["key"])["key"].to_pylist()
        keys = [source.key for source in named_apart(sources, taken)]
        tasks = [
            _Task(source, key, str(folder.resolve()), chosen, present, replace)
            for source, key in zip(sources, keys, strict=True)
        ]
        watch = _Watch(len(tasks), progress)
        outcomes = _told(runner.outcomes(_read_source, tasks), watch)
        findings: list[Finding] = []
        if replace:
            reports, findings = replace_recordings(
                folder, map(_as_read, outcomes), {source.key: path_ends(source) for source in sources}
            )
        else:
            reports = []
            otherwise = _ingested_otherwise(folder, chosen)
            commit_groups(folder, _staged_takes(outcomes, set(present), otherwise, reports), watch.stored)
        reports = _compared(with_copies(reports), folder)
        recover(folder)  # copies of what was committed need not wait
        stale = unusable_splits(Store.open(folder))
    left, said = unclaimed_findings(unclaimed)
    report = IngestReport(str(store), tuple(reports), tuple(map(str, left)), (*findings, *said))
    return dataclasses.replace(report, stale_splits=tuple(stale)) if report.changed else report


def _compared(reports: list[SourceReport], folder: Path) -> list[SourceReport]:
    """Reports, each with what its recording contradicts in the store, with what it is beside others, and its name."""
    store = Store.open(folder)
    digests = store.sources(["sha256"])["sha256"].to_pylist()
    names = dict(zip(digests, recording_names(store), strict=True))
    beside = {digests[row]: found for row, found in findings_beside(store).items()}
    conflicts = conflict_findings(store, {report.sha256 for report in reports if report.state in ("added", "replaced")})
    return [
        dataclasses.replace(
            report,
            findings=(*report.findings, *conflicts.get(report.sha256, ()), *beside.get(report.sha256, ())),
            name=names.get(report.sha256, ""),
        )
        for report in reports
    ]


class _Watch:
    """Tells who watches how many sources were read, and how many of them are in the store: a kill leaves these."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._total, self._progress = total, progress or no_progress
        self._read, self._stored = 0, 0

    def read(self, key: str, is_read: bool) -> None:
        """Take notice of a source that was read, or cannot be."""
        self._read += 1
        self._tell(f"{key} {'read' if is_read else 'not read'}")

    def stored(self, count: int) -> None:
        """Take notice of so many more sources that are in the store."""
        self._stored += count
        self._tell()

    def _tell(self, source: str = "") -> None:
        parts = [source] if source else []
        # nothing is said of a store before the first commit: a few sources are committed at the end, all at once
        parts += [f"{self._stored} stored so far"] if self._stored else []
        self._progress(self._read, self._total, ", ".join(parts))


def _told(outcomes: Iterator[Outcome[_Task, _Read]], watch: _Watch) -> Iterator[Outcome[_Task, _Read]]:
    """The outcomes, each told to who watches; a store that cannot be written ends them, as it is no fault of a source.

    Raises
    ------
    StoreError
        The disk of the store is full, or it may not be written to.
    """
    for outcome in outcomes:
        if isinstance(outcome.error, StoreError) and "errno" in outcome.error.facts:
            raise outcome.error
        watch.read(outcome.task.source.key, outcome.is_ok)
        yield outcome


def _as_read(outcome: Outcome[_Task, _Read]) -> tuple[str, StagedTake | None, str]:
    return outcome.task.source.key, outcome.result.staged if outcome.result else None, str(outcome.error or "")


def _staged_takes(
    outcomes: Iterator[Outcome[_Task, _Read]],
    seen: set[str],
    otherwise: set[str],
    reports: list[SourceReport],
) -> Iterator[StagedTake]:
    """Takes that the store does not have yet, in order; every outcome is noted in ``reports``."""
    for outcome in outcomes:
        reports.append(_report(outcome, seen, otherwise))
        if outcome.result is not None and outcome.result.staged is not None and outcome.result.sha256 not in seen:
            seen.add(outcome.result.sha256)
            yield outcome.result.staged


def _read_source(task: _Task) -> _Read:
    """One source, read, checked and staged; runs in a worker."""
    source, folder = task.source, Path(task.store)
    with refusals_told(source):
        sha256 = source_digest(source)
    if sha256 in task.present and not task.replace:
        return _Read(sha256, None)
    with reading_lock(folder, sha256):
        if (waiting := _staged_so(folder, sha256, task.options)) is not None:
            return _Read(sha256, waiting)
        if not task.replace and sha256 in read_manifest(folder, checked=False)["sources"]:
            # a copy of it was among the sources, and is committed by now
            return _Read(sha256, None)
        return _Read(sha256, _read_and_stage(task, sha256))


def _staged_so(folder: Path, sha256: str, options: IngestOptions) -> StagedTake | None:
    """The take of a source that waits already, read with these options."""
    waiting = find_staged(folder).get(sha256)
    wanted = digest_of(options.document())
    return waiting if waiting and waiting.document["provenance"].get("settings_sha256") == wanted else None


def _read_and_stage(task: _Task, sha256: str) -> StagedTake:
    source, folder = dataclasses.replace(task.source, key=task.key), Path(task.store)
    with Spool(staging_folder(folder, sha256)) as spool:
        with refusals_told(source):
            recording = FORMATS[source.format]().read(source, spool, task.options.mapping)
        spool.close()
        images = SpooledImages(spool.folder, spool.columns())
        # readings beyond 1e8 are left out; other numbers, of fields without such a unit, may overflow to inf
        with np.errstate(over="ignore", invalid="ignore"):
            take = _checked_take(recording, images, sha256, task.options)
        if task.options.strict:
            _refuse_damage(take, source)
        return stage(folder, spool, take)


def _checked_take(recording: Recording, images: SpooledImages, sha256: str, options: IngestOptions) -> Take:
    """The take of a recording, with what the checks of its images found."""
    broken, cut = broken_images(images)
    blank, dark = blank_images(images)
    unseen = set(blank.tolist())
    known = {finding.code for finding in recording.findings}
    said = [finding for finding in (*cut, *dark) if finding.code not in known]

    def shown(rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
        """Images of rows of the sink; none for those of one colour, which are no picture without contact either."""
        return [None if row in unseen else images.decode(np.array([row]))[0] for row in rows.tolist()]

    assembled = assemble(recording, images.columns, shown, sha256, options)
    frames = flag_images(assembled.take.frames, assembled.order, broken, FrameFlag.BROKEN)
    frames = flag_images(frames, assembled.order, blank, FrameFlag.BLANK)
    take = dataclasses.replace(assembled.take, frames=frames)

    def decode(rows: NDArray[np.int64]) -> list[NDArray[np.uint8] | None]:
        return images.decode(assembled.order[rows])

    said = [*said, *check_take(take, decode), *camera_lag(take, decode)]
    findings = pa.concat_tables([take.findings, findings_table(said)])
    return dataclasses.replace(take, findings=findings, status=_worse(take.status, said))


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
            "the store took it with another mapping or other options, and keeps that; with --replace it goes as asked"
        )
        other = Finding("ingested-otherwise", "warning", text)
        said = (other,) if outcome.result.sha256 in otherwise else ()
        return SourceReport(key, "present", findings=said, sha256=outcome.result.sha256)
    return report_of(outcome.task.key, "added", staged)
