"""Who goes where: a draw by keyed hash that depends on nothing but the trajectory's root and the seed.

So the order of a store, the day on which data arrived and what else is there move nobody; only twins, which two
recordings hold, go by the one that came first (see `twins`), and what several sensors of a recording took at one moment
goes by the first of them (see `moments`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from typing import Literal

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.errors import UnknownName, UsageError
from tactiledata.splits.groups import UNIT_KINDS, Groups, group_trajectories
from tactiledata.splits.moments import SIDES
from tactiledata.splits.options import EXCLUDED, SHARES, SplitOptions
from tactiledata.splits.twins import NAME_IT, UNNAMED, unnamed_sensors

MIN_UNITS = 4
"""Fewer units of a kind than this, and ``auto`` holds none of them out: training needs several to generalise from."""
HELD_SHARE = 0.2
"""Share of the units of a kind that ``auto`` holds out; at least one."""

Held = Mapping[str, Sequence[str]]

SPLIT_SCHEMA = pa.schema(
    [
        ("uid", pa.string()),
        ("trajectory", pa.string()),
        ("sensor", pa.string()),
        ("indenter", pa.string()),
        ("root", pa.string()),  # uid of the recorded trajectory that it goes back to
        ("group", pa.string()),  # uid by which it was drawn: that of the first touch of its moment
        ("partition", pa.string()),  # train, val, test, test_unseen, or excluded
        ("unseen_sensor", pa.bool_()),
        ("unseen_indenter", pa.bool_()),
        ("frames", pa.int64()),  # frames that the split takes from it
    ]
)
"""Columns of splits/<name>.parquet, one row a trajectory."""


def draw(uid: str, seed: int, purpose: Literal["part", "hold-out"] = "part") -> float:
    """Return a number in [0, 1) that depends on the uid, the seed and the purpose alone.

    Parameters
    ----------
    uid : str
        Uid of a trajectory, or another name that stays the same.
    seed : int
        Seed of the split.
    purpose : "part" or "hold-out"
        What is drawn; the two draws of one uid do not depend on each other.

    Examples
    --------
    >>> draw("00f1", seed=0) == draw("00f1", seed=0) != draw("00f1", seed=1)
    True
    """
    key = hashlib.blake2b(str(seed).encode(), digest_size=32).digest()
    word = hashlib.blake2b(uid.encode(), digest_size=8, key=key, person=purpose.encode()).digest()
    return (int.from_bytes(word, "big") >> 11) / 2**53


def part_of(draws: NDArray[np.float64], fractions: Sequence[float]) -> NDArray[np.int64]:
    """Index (n,) into ``SHARES`` of draws (n,) in [0, 1); a share of 0 gets nobody."""
    taken = [index for index, share in enumerate(fractions) if share > 0]
    edges = np.cumsum([fractions[index] for index in taken])[:-1]
    return np.asarray(taken)[np.searchsorted(edges, draws, side="right")]


def need_units(trajectories: pa.Table, options: SplitOptions) -> None:
    """Refuse to hold out by name what the store does not hold.

    Raises
    ------
    UnknownName
        A unit was named that the store does not hold.
    """
    if isinstance(options.hold_out, str):
        return
    for kind, names in options.hold_out.items():
        known = {name for name in trajectories[kind].to_pylist() if name}
        for name in names:
            if name not in known:
                raise UnknownName(kind, name, known, "Only units of this store can be held out.")


def choose_held_out(trajectories: pa.Table, options: SplitOptions) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """Units that are held out, by kind, and in words why.

    Raises
    ------
    UnknownName
        A unit was named that the store does not hold.
    """
    if options.hold_out == "none":
        return {}, []
    if not isinstance(options.hold_out, str):
        need_units(trajectories, options)
        return {kind: tuple(sorted(names)) for kind, names in options.hold_out.items()}, []
    held: dict[str, tuple[str, ...]] = {}
    notes: list[str] = []
    for kind in options.strata:
        units = recorded_units(trajectories, kind)
        if kind == "sensor" and (said := unnamed_sensors(units)):
            units = [unit for unit in units if not unit.startswith(UNNAMED)]
            notes.append(f"{said}: none is held out as unseen; {NAME_IT}")
        if len(units) < MIN_UNITS:
            notes.append(
                f"no {kind} is held out: the store has {len(units)} of them ({', '.join(units) or 'none named'}), "
                f"and {MIN_UNITS} are needed"
                + (f"; --hold-out {kind}=… holds some out all the same" if len(units) > 1 else "")
            )
            continue
        ranked = sorted(units, key=lambda unit: draw(f"{kind}\0{unit}", options.seed, "hold-out"))
        held[kind] = tuple(sorted(ranked[: max(1, round(HELD_SHARE * len(units)))]))
    return held, notes


def recorded_units(trajectories: pa.Table, kind: str) -> list[str]:
    """Names of the sensors or indenters of recorded trajectories; of all, where none was recorded."""
    columns = zip(trajectories[kind].to_pylist(), trajectories["parent"].to_pylist(), strict=True)
    pairs = [(name, parent) for name, parent in columns if name]
    return sorted({name for name, parent in pairs if not parent} or {name for name, _ in pairs})


def assign(
    trajectories: pa.Table,
    options: SplitOptions,
    held_out: Held,
    frames: NDArray[np.int64] | None = None,
    flagged: Collection[str] = (),
) -> pa.Table:
    """The partition of every trajectory.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``, n rows in any order.
    options : SplitOptions
    held_out : dict, unit kind -> names
    frames : (n,) int64, optional
        Frames that the split takes from each trajectory; 0 where not given.
    flagged : collection of str
        Uids that go into no part. They take part in the draw all the same, so that a flag moves nobody else.

    Returns
    -------
    pa.Table
        ``SPLIT_SCHEMA``, rows in the order given.

    Raises
    ------
    StoreError
        A uid twice, or parents in a circle.
    UsageError
        Every trajectory carries a held-out unit, or those that do not are flagged.
    """
    groups = group_trajectories(trajectories)
    key = {uid: draw(uid, options.seed) for uid in set(groups.moment)}
    shares = part_of(np.array([key[uid] for uid in groups.moment], float), options.fractions)
    own, of_group = _carried(trajectories, groups, held_out)
    any_own = np.logical_or.reduce(list(own.values()))
    any_group = np.logical_or.reduce(list(of_group.values()))
    partition = np.asarray(SHARES, object)[shares]
    partition[any_own] = EXCLUDED
    partition[any_group] = "test_unseen"
    uids = trajectories["uid"].to_pylist()
    partition[_between_parts(uids, groups, partition)] = EXCLUDED
    partition[_apart_from_their_moment(uids, groups, partition)] = EXCLUDED
    if len(partition) and not np.isin(partition, SHARES).any():
        raise UsageError(
            f"every one of {len(partition)} trajectories is held out ({describe_held(held_out)})",
            "trajectories that are left to train on",
            "Hold out fewer sensors or indenters: --hold-out.",
        )
    if flagged:
        partition[pc.is_in(trajectories["uid"], value_set=pa.array(list(flagged), pa.string())).to_numpy()] = EXCLUDED
        if len(partition) and not np.isin(partition, SHARES).any():
            raise UsageError(
                f"all trajectories that could be learned from are flagged ({len(flagged)} of {len(partition)})",
                "trajectories that are left to train on",
                "Take flags off with `tactiledata flag STORE TRAJECTORY --remove`, or split with --with-flagged.",
            )
    count = np.zeros(trajectories.num_rows, np.int64) if frames is None else frames
    columns = {
        **{name: trajectories[name] for name in ("uid", "trajectory", *UNIT_KINDS)},
        "root": groups.root,
        "group": groups.moment,
        "partition": partition.tolist(),
        **{f"unseen_{kind}": own[kind] | of_group[kind] for kind in UNIT_KINDS},
        "frames": count,
    }
    return pa.table({name: columns[name] for name in SPLIT_SCHEMA.names}, schema=SPLIT_SCHEMA)


def _between_parts(uids: Sequence[str], groups: Groups, partition: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Whether each trajectory (n,) goes back to a touch that no part may have.

    Such a touch came after touches that it overlaps and that stand in several parts, or it carries a held-out unit
    while they do not. What was derived from it is in no part either.
    """
    facts = list(zip(uids, groups.root, groups.group, partition.tolist(), groups.founding, strict=True))
    part_of_group = {group: part for _, _, group, part, founds in facts if founds}
    barred = {
        uid
        for uid, root, group, part, founds in facts
        if uid == root and not founds  # recorded, and it joined a group that was there
        if any(part_of_group[other] != part for other in (group, *groups.rivals.get(uid, ())))
    }
    return np.array([root in barred for root in groups.root], bool)


def _apart_from_their_moment(uids: Sequence[str], groups: Groups, partition: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Whether each trajectory (n,) goes back to a touch that would stand on another side than its moment.

    Of a moment that is learned from, the touches of held-out units are in no part. A recording that repeats touches of
    a moment gives way: what it holds on another side, or between two sides, is in no part.
    """
    recorded = [row for row, (uid, root) in enumerate(zip(uids, groups.root, strict=True)) if uid == root]
    side = [SIDES.get(part, "") for part in partition.tolist()]
    sides_of: dict[str, set[str]] = {}
    for row in recorded:
        if uids[row] not in groups.met and side[row]:
            sides_of.setdefault(groups.moment[row], set()).add(side[row])
    # units that are not held out are drawn together, so that a second side is that of the held-out ones
    sides_of = {moment: sides - {"test"} or sides for moment, sides in sides_of.items()}
    barred = {
        uids[row]
        for row in recorded
        if side[row]
        if set().union(*(sides_of.get(moment, ()) for moment in groups.met.get(uids[row], (groups.moment[row],))))
        != {side[row]}
    }
    return np.array([root in barred for root in groups.root], bool)


def _carried(
    trajectories: pa.Table, groups: Groups, held_out: Held
) -> tuple[dict[str, NDArray[np.bool_]], dict[str, NDArray[np.bool_]]]:
    """Return two masks (n,) for each kind of unit: what carries a held-out unit itself, and what has it by a founder of
    its group.
    """
    own, of_group = {}, {}
    for kind in UNIT_KINDS:
        names = set(held_out.get(kind, ()))
        own[kind] = np.array([name in names for name in trajectories[kind].to_pylist()], bool)
        held_groups = {
            group
            for group, is_held, founds in zip(groups.group, own[kind], groups.founding, strict=True)
            if is_held and founds
        }
        of_group[kind] = np.array([group in held_groups for group in groups.group], bool)
    return own, of_group


def describe_held(held_out: Held) -> str:
    """Held-out units in words."""
    return "; ".join(f"{kind} {', '.join(names)}" for kind, names in held_out.items() if names) or "nobody"
