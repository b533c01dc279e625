"""Leaks that the tables show, each found by a pure function: tables in, findings out."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.splits.assign import Held, assign, recorded_units
from tactiledata.splits.groups import UNIT_KINDS, family_roots, overlapping_touches, shared_place_of
from tactiledata.splits.options import PARTITIONS, SplitOptions
from tactiledata.splits.twins import NAME_IT, UNNAMED, unnamed_sensors

SHOWN = 3
"""Cases that a finding's message names before it says how many more there are."""


def partition_codes(partition: NDArray[np.object_]) -> NDArray[np.int64]:
    """Index (n,) into ``PARTITIONS`` of partitions (n,) by name; -1 for what is in no part."""
    index = {part: code for code, part in enumerate(PARTITIONS)}
    return np.array([index.get(part, -1) for part in partition], np.int64)


def leak(code: str, what: str, cases: Iterable[str], count: int) -> list[Finding]:
    """Return a finding of severity "damage" that names the first cases; none where there are none.

    Parameters
    ----------
    code : str
        Code of the finding.
    what : str
        The leak in words.
    cases : iterable of str
        Each case in words; only the first are asked for.
    count : int
        Number of cases.
    """
    if not count:
        return []
    shown = [case for case, _ in zip(cases, range(SHOWN), strict=False)]
    more = f" and {count - len(shown)} more" if count > len(shown) else ""
    return [Finding(code, "damage", f"{what}: {'; '.join(shown)}{more}", count=count)]


def shared_uids(table: pa.Table) -> list[Finding]:
    """Trajectories that a split's table puts into several partitions."""
    parts: dict[str, set[str]] = {}
    for uid, part in zip(table["uid"].to_pylist(), table["partition"].to_pylist(), strict=True):
        parts.setdefault(uid, set()).add(part)
    shared = {uid: found for uid, found in parts.items() if len(found) > 1}
    cases = (f"{uid} in {' and '.join(sorted(found))}" for uid, found in sorted(shared.items()))
    return leak("shared-trajectory", "trajectories stand in several parts", cases, len(shared))


def parted_touches(trajectories: pa.Table, part: NDArray[np.int64]) -> list[Finding]:
    """Recorded trajectories of one sensor that overlap in time and stand in different partitions.

    Across recordings only absolute times are compared: a clock that starts at 0 tells no moment.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``, n rows.
    part : (n,) int
        Codes of `partition_codes`.
    """
    recorded = pc.equal(trajectories["parent"], "").to_numpy()
    rows = np.flatnonzero((part >= 0) & recorded)
    leader = rows[
        overlapping_touches(
            shared_place_of(trajectories)[rows],
            trajectories["start_ns"].to_numpy()[rows],
            trajectories["end_ns"].to_numpy()[rows],
        )
    ]
    parted = groups_in_several_parts(leader, part[rows])
    names, source = trajectories["trajectory"], trajectories["source"].to_numpy()

    def cases() -> Iterable[str]:
        for group in parted:
            members = rows[leader == group]
            is_twin = len(np.unique(source[members])) > 1
            shown = members[np.unique(part[members], return_index=True)[1]]
            yield " and ".join(
                f"{names[int(row)].as_py()!r}{f' of recording {source[row]}' * is_twin} ({PARTITIONS[part[row]]})"
                for row in shown
            )

    return leak(
        "touch-in-two-parts",
        "trajectories that overlap in time on one sensor are in different parts",
        cases(),
        len(parted),
    )


def groups_in_several_parts(group: NDArray[np.int64], part: NDArray[np.int64]) -> NDArray[np.int64]:
    """Groups whose members are not all of one part; ``group`` and ``part`` are (n,)."""
    # sorting one number for a group and its part is many times faster than sorting pairs
    pairs = np.unique(group * len(PARTITIONS) + part)
    names, counts = np.unique(pairs // len(PARTITIONS), return_counts=True)
    return names[counts > 1]


def parted_families(trajectories: pa.Table, part: NDArray[np.int64]) -> list[Finding]:
    """Derived trajectories in another partition than others of their family; arguments as in `parted_touches`."""
    uids = trajectories["uid"].to_pylist()
    roots = np.array(family_roots(uids, trajectories["parent"].to_pylist()), object)
    rows = np.flatnonzero(part >= 0)
    names, family = np.unique(roots[rows].astype(str), return_inverse=True)
    parted = groups_in_several_parts(family, part[rows])

    def cases() -> Iterable[str]:
        for number in parted:
            members = rows[family == number]
            yield f"family of {names[number]} in " + " and ".join(PARTITIONS[code] for code in np.unique(part[members]))

    return leak(
        "derived-away-from-parent", "derived trajectories stand apart from what they come from", cases(), len(parted)
    )


def parted_frames(frames: pa.Table, taken: NDArray[np.bool_], part: NDArray[np.int64]) -> list[Finding]:
    """Frames whose parent frame is in another partition.

    Parameters
    ----------
    frames : pa.Table
        Columns ``trajectory`` and ``parent_frame``, n rows.
    taken : (n,) bool
        Frames that the split takes.
    part : (n_trajectories,) int
    """
    parent = frames["parent_frame"].to_numpy()
    derived = np.flatnonzero(taken & (parent >= 0))
    lost = int((parent[derived] >= len(parent)).sum())
    derived = derived[parent[derived] < len(parent)]
    trajectory = frames["trajectory"].to_numpy()
    own = part[trajectory[derived]]
    origin_trajectory = trajectory[parent[derived]]
    origin = np.where(origin_trajectory >= 0, part[origin_trajectory], -1)
    bad = derived[(own >= 0) & (origin >= 0) & (own != origin)]
    where = dict(zip(derived.tolist(), zip(own.tolist(), origin.tolist(), strict=True), strict=True))
    cases = (
        f"frame {row} ({PARTITIONS[where[row][0]]}) from frame {parent[row]} ({PARTITIONS[where[row][1]]})"
        for row in bad.tolist()
    )
    found = leak(
        "derived-frame-away-from-parent", "frames stand apart from the frame they were derived from", cases, len(bad)
    )
    if lost:
        message = f"{lost} frames name a parent frame that the store does not hold: whether they leak is not known"
        found.append(Finding("unknown-parent-frame", "warning", message, count=lost))
    return found


def held_out_elsewhere(trajectories: pa.Table, part: NDArray[np.int64], held_out: Held) -> list[Finding]:
    """Return findings on trajectories with a held-out unit in train, val or test.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``, n rows.
    part : (n,) int
        Codes of `partition_codes`.
    held_out : dict, unit kind -> names
        Sensors and indenters that are held out.
    """
    found: list[Finding] = []
    is_seen = (part >= 0) & (part != PARTITIONS.index("test_unseen"))
    for kind in UNIT_KINDS:
        names = pa.array(list(held_out.get(kind, ())), pa.string())
        rows = np.flatnonzero(is_seen & pc.is_in(trajectories[kind], value_set=names).to_numpy())
        shown = trajectories.take(rows[:SHOWN]).to_pylist()
        cases = (
            f"{case['trajectory']!r} of {kind} {case[kind]} in {PARTITIONS[part[row]]}"
            for case, row in zip(shown, rows, strict=False)
        )
        found += leak(f"held-out-{kind}-seen", f"a held-out {kind} is not unseen", cases, len(rows))
    return found


def sensors_without_serial(trajectories: pa.Table) -> list[Finding]:
    """Return a warning where sensors have no serial, as long as there is another that each could be.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``.
    """
    sensors = recorded_units(trajectories, "sensor")
    said = unnamed_sensors(sensors)
    if not said or len(sensors) == 1:
        return []
    message = f"{said}: whether one camera is in several parts, or seen although held out, cannot be told; {NAME_IT}"
    return [
        Finding("sensor-without-serial", "warning", message, count=sum(name.startswith(UNNAMED) for name in sensors))
    ]


def unlike_drawn(
    trajectories: pa.Table,
    table: pa.Table,
    partition: NDArray[np.object_],
    options: SplitOptions,
    held_out: Held,
    flagged: Collection[str] = (),
) -> list[Finding]:
    """Return findings on trajectories that are not where the split's own options put them: the table was changed.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``, n rows.
    table : pa.Table
        ``SPLIT_SCHEMA``
    partition : (n,)
        Partition of each trajectory as the table says, ``None`` where it says none.
    options : SplitOptions
        Options that the split's document states.
    held_out : dict, unit kind -> names
        Sensors and indenters that its document calls held out.
    flagged : collection of str
        Uids that its document says were left out because they were flagged.
    """
    drawn = assign(trajectories, options, held_out, flagged=flagged)
    expected = np.asarray(drawn["partition"].to_pylist(), object)
    known = np.array([part is not None for part in partition], bool)
    moved = np.flatnonzero(known & (partition != expected))
    uids = trajectories["uid"]
    cases = (f"{uids[int(row)].as_py()} in {partition[row]}, drawn for {expected[row]}" for row in moved)
    found = leak("not-as-drawn", "trajectories are not where the split's options put them", cases, len(moved))
    row_of = pc.index_in(trajectories["uid"], value_set=table["uid"].combine_chunks())
    for kind in UNIT_KINDS:
        said = table[kind].combine_chunks().take(row_of.combine_chunks())
        own = trajectories[kind].combine_chunks()
        # where the table has no such trajectory the comparison is null, which counts as no difference
        wrong = np.flatnonzero(pc.fill_null(pc.not_equal(said, own), False).to_numpy(zero_copy_only=False))
        cases = (
            f"{uids[row].as_py()} of {kind} {own[row].as_py()!r} in the store, {said[row].as_py()!r} in the table"
            for row in wrong.tolist()
        )
        found += leak("unit-renamed", f"the split's table names another {kind} than the store", cases, len(wrong))
    return found


def frame_in_words(row: int, trajectory: int, names: Sequence[str]) -> str:
    """Name a frame by its number, and by its trajectory where names are known.

    Parameters
    ----------
    row : int
        Number of the frame.
    trajectory : int
        Number of its trajectory.
    names : sequence of str
        Full names of the trajectories of the store; may be empty.
    """
    return f"frame {row} of {names[trajectory]}" if names else f"frame {row}"


def payload_words(frames: pa.Table) -> NDArray[np.uint64]:
    """Two checks (n_frames,) of each encoded image in one word: 32 bits of CRC-32C, 31 of length.

    Equal words mean equal bytes for all practical purposes.
    """
    length, crc = (frames[name].to_numpy().astype(np.uint64) for name in ("length", "crc32c"))
    return (length << np.uint64(32)) | crc


def identical_payloads(
    frames: pa.Table, taken: NDArray[np.bool_], part: NDArray[np.int64], names: Sequence[str] = ()
) -> list[Finding]:
    """Encoded images of equal length and CRC-32C in different partitions: the same bytes.

    Parameters
    ----------
    frames : pa.Table
        Columns ``trajectory``, ``length``, ``crc32c``, ``height``, ``width``, n rows.
    taken : (n,) bool
    part : (n_trajectories,) int
    names : sequence of str
        Full names of the trajectories, for the messages; frames are told by their numbers where it is empty.
    """
    length, trajectory = frames["length"].to_numpy(), frames["trajectory"].to_numpy()
    rows = np.flatnonzero(taken & (length > 0))
    where = part[trajectory[rows]]
    rows, where = rows[where >= 0], where[where >= 0]
    word = payload_words(frames)[rows]
    # few words come twice; only those need a group
    order = np.argsort(word, kind="stable")
    twice = word[order][1:] == word[order][:-1]
    among = np.unique(np.concatenate([order[1:][twice], order[:-1][twice]]))
    rows, where = rows[among], where[among]
    group = np.unique(word[among], return_inverse=True)[1]
    parted = groups_in_several_parts(group, where)

    def cases() -> Iterable[str]:
        for number in parted:
            members = np.flatnonzero(group == number)[:4]
            yield " and ".join(
                f"{frame_in_words(rows[m], trajectory[rows[m]], names)} ({PARTITIONS[where[m]]})" for m in members
            )

    return leak("identical-image", "images of the same bytes are in different parts", cases(), len(parted))
