"""The audit of a split: everything that would let a model be tested on what it was trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.image_batches import image_batches
from tactiledata.contract.image_bytes import size_fault
from tactiledata.contract.progress import Progress
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import SchemaError, StoreError
from tactiledata.splits import leaks, moment_leaks
from tactiledata.splits.again import command
from tactiledata.splits.copies import Portrait, compare_images, sensor_noise
from tactiledata.splits.fingerprints import CELLS, fingerprint, near_pairs
from tactiledata.splits.flagged import FLAGGED, flag_findings
from tactiledata.splits.groups import codes
from tactiledata.splits.manifest import Split, coverage_problem, partition_rows, read_split
from tactiledata.splits.options import PARTITIONS, SHARES
from tactiledata.splits.select import FRAME_COLUMNS, taken_frames
from tactiledata.store.read.named_trajectories import full_names

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

AUDIT_TRAJECTORY_COLUMNS = ("uid", "trajectory", "source", "sensor", "indenter", "start_ns", "end_ns", "parent")
AUDIT_FRAME_COLUMNS = (*FRAME_COLUMNS, "parent_frame", "length", "crc32c")
BATCH = 256
"""Images read at a time, where they are small; large ones are fewer (`image_batches`)."""
NOISE_SAMPLE = 16
"""Trajectories of a sensor from which its noise is estimated."""
MAX_PAIRS = 5000
"""Pairs of near images that are compared pixel by pixel, nearest first (some 0.1 s each)."""


@dataclass(frozen=True)
class AuditReport:
    """What an audit found.

    Parameters
    ----------
    name : str
        The split.
    findings : tuple of Finding
        Severity "damage" is a leak, or a split that cannot be trusted.
    checked : dict
        How many trajectories, frames, images and pairs of near images were looked at.
    again : str
        The command that brings the split up to date.
    """

    name: str
    findings: tuple[Finding, ...]
    checked: dict[str, int]
    again: str = "tactiledata split"

    @property
    def leaks(self) -> tuple[Finding, ...]:
        """The findings for which the split must not be used."""
        return tuple(finding for finding in self.findings if finding.severity == "damage")

    def document(self) -> dict[str, Any]:
        """The report as JSON."""
        return {
            "name": self.name,
            "leaks": len(self.leaks),
            "checked": self.checked,
            "findings": [
                {"code": f.code, "severity": f.severity, "message": f.message, "count": f.count} for f in self.findings
            ],
        }

    def lines(self) -> list[str]:
        """The report for people."""
        looked = ", ".join(f"{count} {what}" for what, count in self.checked.items()) or "nothing could be checked"
        return [
            f"split {self.name!r}: {self._verdict()} ({looked})",
            *(f"- {f.code}: {f.message}" for f in self.findings),
        ]

    def _verdict(self) -> str:
        """Say in words whether a split leaks, and first whether it can be judged at all."""
        codes = [finding.code for finding in self.leaks]
        if "split-changed" in codes:
            return "its files were changed or damaged, so that nothing can be said about leaks"
        kinds = [code for code in codes if code not in ("split-out-of-date", FLAGGED)]
        leaks = f"{counted(len(kinds), 'kind')} of leak" if kinds else "no leak found"
        empty = [finding for finding in self.findings if finding.code == "split-empty-part"]
        leaks += f", but {empty[0].message.partition(':')[0]}" if empty else ""
        stale = f"out of date: the store holds other trajectories; run `{self.again}` again; "
        flagged = f"it holds flagged trajectories; run `{self.again}` again; " if FLAGGED in codes else ""
        return (stale if "split-out-of-date" in codes else "") + flagged + leaks


def audit(store: Store, name: str = "default", images: bool = True, progress: Progress | None = None) -> AuditReport:
    """What leaks in a split of a store.

    Parameters
    ----------
    store : Store
    name : str
    images : bool
        Also decode the images that the split takes and look for copies of one image in different partitions.
    progress : callable, optional
        Called with images done and images in all.

    Raises
    ------
    MissingSplit, UnknownName
        The store has no split (of that name).
    """
    try:
        split = read_split(store, name)
    except (StoreError, SchemaError) as error:
        message = f"the split's files do not fit each other: {error}"
        return AuditReport(name, (Finding("split-changed", "damage", message),), {})
    trajectories = store.trajectories(list(AUDIT_TRAJECTORY_COLUMNS))
    frames = store.frames(list(AUDIT_FRAME_COLUMNS))
    again = command(store.location, name, split.document["options"])
    found = [*audit_tables(split, trajectories, frames, again, full_names(store)), *flag_findings(store, split, again)]
    checked = {"trajectories": trajectories.num_rows, "frames": frames.num_rows}
    if images:
        part = leaks.partition_codes(partition_rows(split, trajectories["uid"]))
        more, counts = _audit_images(store, frames, split, part, progress)
        found += more
        checked |= counts
    return AuditReport(name, tuple(found), checked, again)


def audit_tables(
    split: Split,
    trajectories: pa.Table,
    frames: pa.Table,
    again: str = "tactiledata split",
    names: Sequence[str] = (),
) -> list[Finding]:
    """What leaks as the tables show it.

    Parameters
    ----------
    split : Split
    trajectories, frames : pa.Table
        The columns ``AUDIT_TRAJECTORY_COLUMNS`` and ``AUDIT_FRAME_COLUMNS``.
    again : str
        The command that brings the split up to date, for the message.
    names : sequence of str
        Full names of the trajectories, for the messages.
    """
    found: list[Finding] = []
    if problem := coverage_problem(split, trajectories["uid"]):
        message = f"the split and the store do not hold the same trajectories: {problem}; run `{again}` again"
        found.append(Finding("split-out-of-date", "damage", message))
    partition = partition_rows(split, trajectories["uid"])
    part = leaks.partition_codes(partition)
    taken = taken_frames(frames, split.force)
    found += leaks.shared_uids(split.table)
    drawn_without = split.document.get("flagged", ())
    found += leaks.unlike_drawn(trajectories, split.table, partition, split.options, split.held_out, drawn_without)
    found += leaks.held_out_elsewhere(trajectories, part, split.held_out)
    found += leaks.sensors_without_serial(trajectories)
    found += leaks.parted_families(trajectories, part)
    found += leaks.parted_touches(trajectories, part)
    found += moment_leaks.parted_moments(trajectories, part)
    found += moment_leaks.parted_recordings(trajectories, part)
    found += leaks.parted_frames(frames, taken, part)
    found += leaks.identical_payloads(frames, taken, part, names)
    return [*found, *empty_parts(split, part, frames["trajectory"].to_numpy()[taken])]


def empty_parts(split: Split, part: NDArray[np.int64], owners: NDArray[np.integer]) -> list[Finding]:
    """A warning where a part that was asked for holds no trajectory, or no frame: nothing can leak from or into it.

    Parameters
    ----------
    split : Split
    part : (n_trajectories,) int
        Codes of `leaks.partition_codes`.
    owners : (n,) int
        Trajectory of each frame that the split takes.
    """
    wanted = [name for name, share in zip(SHARES, split.options.fractions, strict=True) if share > 0]
    wanted += [PARTITIONS[-1]] if any(split.held_out.values()) else []
    trajectories, frames = (np.bincount(codes[codes >= 0], minlength=len(PARTITIONS)) for codes in (part, part[owners]))
    none, unseen = (
        [name for name in wanted if is_so[PARTITIONS.index(name)]]
        for is_so in (trajectories == 0, (trajectories > 0) & (frames == 0))
    )
    told = [f"{' and '.join(none)} {_verb(none)} no trajectory"] if none else []
    told += [f"{' and '.join(unseen)} {_verb(unseen)} trajectories and no frame that the split takes"] if unseen else []
    if not told:
        return []
    message = f"{'; '.join(told)}: nothing can be learned or tested there, and no leak found says nothing of it"
    return [Finding("split-empty-part", "warning", message, count=len(none) + len(unseen))]


def parts_without(store: Store, split: Split) -> list[Finding]:
    """A warning where a part of a split that was asked for holds no trajectory, or no frame."""
    frames = store.frames(list(FRAME_COLUMNS))
    part = leaks.partition_codes(partition_rows(split, store.trajectories(["uid"])["uid"]))
    return empty_parts(split, part, frames["trajectory"].to_numpy()[taken_frames(frames, split.force)])


def _verb(names: list[str]) -> str:
    return "has" if len(names) == 1 else "have"


def _audit_images(
    store: Store, frames: pa.Table, split: Split, part: NDArray[np.int64], progress: Progress | None
) -> tuple[list[Finding], dict[str, int]]:
    trajectory = frames["trajectory"].to_numpy()
    rows = np.flatnonzero(taken_frames(frames, split.force))
    where = part[trajectory[rows]]
    rows, where = rows[where >= 0], where[where >= 0]
    too_large = _too_large(store, rows)
    prints = np.full((len(rows), CELLS), np.nan, np.float32)
    prints[~too_large], unreadable = _fingerprints(store, rows[~too_large], progress)
    near = near_pairs(prints, where)
    words = leaks.payload_words(frames)[rows]
    pairs = near.only(words[near.first] != words[near.second])  # those of the same bytes are told as such
    whole = rows[np.isfinite(prints[:, 0])]
    noise = _noise_by_sensor(store, whole, trajectory, codes(store.frames(["sensor"])["sensor"]))
    copies = _copies(store, rows[pairs.first[:MAX_PAIRS]], rows[pairs.second[:MAX_PAIRS]], noise)
    names, parts = full_names(store), dict(zip(rows.tolist(), where.tolist(), strict=True))
    cases = (
        " and ".join(f"{leaks.frame_in_words(row, trajectory[row], names)} ({PARTITIONS[parts[row]]})" for row in pair)
        for pair in copies
    )
    found = leaks.leak("near-duplicate-image", "copies of one image are in different parts", cases, len(copies))
    if len(pairs) > MAX_PAIRS:
        left = len(pairs) - MAX_PAIRS
        message = (
            f"{len(pairs)} pairs of images across parts look alike; the nearest {MAX_PAIRS} were compared in detail"
        )
        found.append(Finding("near-pairs-not-compared", "warning", message, count=left))
    found += _not_compared(rows[too_large].tolist(), "too large to be decoded", "check --repair")
    # an image may fit its checksum and not decode
    found += _not_compared(unreadable, "damaged", "check --decode --repair")
    decoded = len(rows) - len(unreadable) - int(too_large.sum())
    blank = decoded - len(whole)
    if blank:
        message = f"{blank} images are of one grey: whether they are copies cannot be told"
        found.append(Finding("blank-image", "warning", message, count=blank))
    return found, {"images": decoded, "near pairs": min(len(pairs), MAX_PAIRS)}


def _sizes(store: Store, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows and columns of pixels (n, 2) of frames."""
    sizes = store.frames(["height", "width"])
    return np.stack([sizes[side].to_numpy().astype(np.int64)[rows] for side in ("height", "width")], axis=1)


def _too_large(store: Store, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each image (n,) is beyond the limit of decoded size, by the table of frames."""
    return np.array([bool(size_fault(height, width)) for height, width in _sizes(store, rows).tolist()], bool)


def _not_compared(rows: list[int], why: str, command: str) -> list[Finding]:
    if not rows:
        return []
    are = agreeing(len(rows), "is", "are")
    message = (
        f"{counted(len(rows), 'image')} {are} {why} and not compared, first frame {rows[0]}: "
        f"`tactiledata {command}` marks such images, and training leaves them out"
    )
    return [Finding("images-not-compared", "warning", message, count=len(rows))]


def _fingerprints(
    store: Store, rows: NDArray[np.int64], progress: Progress | None
) -> tuple[NDArray[np.float32], list[int]]:
    """Fingerprints (n, CELLS) of frames, NaN where there is none, and the frames that do not decode."""
    prints = np.full((len(rows), CELLS), np.nan, np.float32)
    unreadable: list[int] = []
    for start, stop in image_batches(_sizes(store, rows).prod(axis=1), BATCH):
        for offset, image in enumerate(_readable(store, rows[start:stop], unreadable)):
            if image is not None:
                prints[start + offset] = fingerprint(image)
        if progress is not None:
            progress(stop, len(rows))
    return prints, unreadable


def _noise_by_sensor(
    store: Store, rows: NDArray[np.int64], trajectory: NDArray[np.int32], sensor: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Noise (n_frames,) of each frame's sensor, grey levels, from frames of different trajectories."""
    noise = np.zeros(len(sensor))
    for unit in np.unique(sensor[rows]):
        own = rows[sensor[rows] == unit]
        first = np.unique(trajectory[own], return_index=True)[1]
        spread = own[first[np.linspace(0, len(first) - 1, min(NOISE_SAMPLE, len(first))).astype(int)]]
        # one picture at a time: sensor_noise keeps two
        noise[sensor == unit] = sensor_noise(np.asarray(store.images([row])[0]) for row in spread.tolist())
    return noise


def _copies(
    store: Store, first: NDArray[np.int64], second: NDArray[np.int64], noise: NDArray[np.float64]
) -> list[tuple[int, int]]:
    """The pairs of frames that are copies of one image."""

    @lru_cache(maxsize=BATCH)
    def portrait(row: int) -> Portrait:
        return Portrait(np.asarray(store.images(np.array([row]))[0]))

    pairs = zip(first.tolist(), second.tolist(), strict=True)
    return [
        (one, other)
        for one, other in pairs
        if compare_images(portrait(one), portrait(other), float(min(noise[one], noise[other]))).is_copy
    ]


def _readable(store: Store, rows: NDArray[np.int64], unreadable: list[int]) -> list[NDArray[np.uint8] | None]:
    """The images of rows; ``None`` for those that do not decode, which are noted."""
    try:
        return [np.asarray(image) for image in store.images(rows)]
    except StoreError:
        if len(rows) == 1:
            unreadable.append(int(rows[0]))
            return [None]
    return [image for row in rows for image in _readable(store, np.array([row]), unreadable)]
