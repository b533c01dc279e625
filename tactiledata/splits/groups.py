"""Which trajectories belong together: families of derived ones, touches held twice, moments of several sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.errors import StoreError
from tactiledata.splits.moments import join_moments
from tactiledata.splits.twins import UNNAMED, join_twins, tells_a_moment

UNIT_KINDS = ("sensor", "indenter")
"""Columns of the trajectories table whose values are units: what can be held out and what strata are made of."""


@dataclass(frozen=True)
class Groups:
    """Who must stand together.

    Parameters
    ----------
    root : (n,) list of str
        Uid of the recorded trajectory that each one goes back to; its own uid for recorded ones.
    group : (n,) list of str
        Uid of the touch of one sensor that each one is: the root's, or that of the first of several that overlap.
    moment : (n,) list of str
        Uid by which each one is drawn: that of its group, or, where several sensors of a recording took touches at one
        moment, of the first of them.
    founding : (n,) bool
        Whether it is a recorded trajectory of the recording that brought its group to the store.
    rivals : dict, root -> uids
        Groups that a touch overlaps beside its own: it bridges touches that were apart when it came.
    met : dict, root -> uids
        Moments that were there when a recording came that repeats some of their touches.
    """

    root: list[str]
    group: list[str]
    moment: list[str]
    founding: NDArray[np.bool_]
    rivals: Mapping[str, tuple[str, ...]]
    met: Mapping[str, tuple[str, ...]]


def family_roots(uids: Sequence[str], parents: Sequence[str]) -> list[str]:
    """The uid at the end of each trajectory's chain of parents.

    A parent that the table does not hold ends the chain, so a derived trajectory in a store of its own is drawn as its
    parent is in the other store.

    Parameters
    ----------
    uids : (n,) str
    parents : (n,) str
        Empty for recorded trajectories.

    Raises
    ------
    StoreError
        A chain of parents that closes on itself.

    Examples
    --------
    >>> family_roots(["a", "b", "c"], ["", "a", "b"])
    ['a', 'a', 'a']
    """
    parent_of = {uid: parent for uid, parent in zip(uids, parents, strict=True) if parent}
    if not parent_of:
        return list(uids)
    known: dict[str, str] = {}
    for uid in uids:
        chain: list[str] = []
        at = uid
        while at in parent_of and at not in known:
            chain.append(at)
            at = parent_of[at]
            if len(chain) > len(parent_of):
                raise StoreError(
                    f"trajectory {uid!r} is derived from itself (parents {' <- '.join(chain[:5])} …)",
                    "parents that lead to a recorded trajectory",
                    "The store's trajectories table is damaged: run `tactiledata check`.",
                    uid=uid,
                )
        end = known.get(at, at)
        known.update(dict.fromkeys(chain, end))
    return [known.get(uid, uid) for uid in uids]


def overlapping_touches(
    place: NDArray[np.int64], start: NDArray[np.int64], end: NDArray[np.int64]
) -> NDArray[np.int64]:
    """A number for each interval, equal for intervals of one place that overlap, directly or through others.

    Parameters
    ----------
    place : (n,) int
        Which recording and sensor.
    start, end : (n,) int64 ns
        Half-open intervals; an empty one overlaps nothing.

    Returns
    -------
    (n,) int64
        Row of the first interval (earliest start) that it is connected with; its own row where it stands alone.
    """
    if not len(place):
        return np.empty(0, np.int64)
    order = np.lexsort((np.arange(len(place)), end, start, place))
    # ranks instead of nanoseconds leave room to put one place behind the other in a single running maximum
    ranks = np.unique(np.concatenate([start, end]), return_inverse=True)[1].reshape(2, -1)
    first, last = ranks[0][order], ranks[1][order]
    base = np.unique(place[order], return_inverse=True)[1] * (2 * len(place) + 1)
    reach = np.maximum.accumulate(base + np.where(last > first, last, 0))
    is_new = np.ones(len(order), bool)
    is_new[1:] = (base + first)[1:] >= reach[:-1]
    is_new |= last <= first
    leader = np.empty(len(order), np.int64)
    # an empty interval is its own leader and must not lead those that follow it
    heads = np.where(is_new & (last > first), np.arange(len(order)), -1)
    running = np.maximum.accumulate(heads)
    leader[order] = order[np.where(last > first, running, np.arange(len(order)))]
    return leader


def place_of(trajectories: pa.Table) -> NDArray[np.int64]:
    """A number (n,) for each pair of recording and sensor."""
    source = trajectories["source"].to_numpy().astype(np.int64)
    sensor = codes(trajectories["sensor"])
    return source * (int(sensor.max(initial=0)) + 1) + sensor


def shared_place_of(trajectories: pa.Table) -> NDArray[np.int64]:
    """Number the places like `place_of`, with one number for a sensor in all recordings whose times tell a moment.

    Sensors that a recording leaves unnamed have another made-up name in each: there only equal spans are one place.
    """
    sensor = trajectories["sensor"].combine_chunks().cast(pa.string())
    start, end = (trajectories[name].combine_chunks() for name in ("start_ns", "end_ns"))
    is_absolute = tells_a_moment(start.to_numpy(), pc.not_equal(sensor, "").to_numpy(zero_copy_only=False))
    span = pc.binary_join_element_wise(start.cast(pa.string()), end.cast(pa.string()), "-")
    shared = pc.if_else(pc.starts_with(sensor, UNNAMED), span, sensor)
    return np.where(is_absolute, -1 - codes(pa.chunked_array([shared])), place_of(trajectories))


def codes(column: pa.ChunkedArray) -> NDArray[np.int64]:
    """A number (n,) for each distinct text of a column."""
    encoded = pc.dictionary_encode(column.combine_chunks().cast(pa.string()))
    return np.asarray(encoded.indices.to_numpy(zero_copy_only=False), np.int64)


def group_trajectories(trajectories: pa.Table) -> Groups:
    """Who must stand together, of a table with ``TRAJECTORY_SCHEMA``.

    Raises
    ------
    StoreError
        A uid that stands twice, or parents in a circle.
    """
    uids, parents = trajectories["uid"].to_pylist(), trajectories["parent"].to_pylist()
    if len(set(uids)) != len(uids):
        seen: set[str] = set()
        twice = next(uid for uid in uids if uid in seen or seen.add(uid))  # type: ignore[func-returns-value]
        raise StoreError(
            f"the uid {twice!r} stands twice in the trajectories table",
            "one row for each trajectory",
            "The store is damaged: run `tactiledata check`.",
            uid=twice,
        )
    roots = family_roots(uids, parents)
    # in the order of their uids, so that the order of the table decides no tie
    rows = np.array(sorted((row for row, parent in enumerate(parents) if not parent), key=uids.__getitem__), np.int64)
    recorded = trajectories.select(["source", "sensor", "start_ns", "end_ns"]).take(rows)
    start, end = recorded["start_ns"].to_numpy(), recorded["end_ns"].to_numpy()
    source = recorded["source"].to_numpy().astype(np.int64)
    cluster = overlapping_touches(place_of(recorded), start, end)
    component = overlapping_touches(shared_place_of(recorded), start, end)
    joined = join_twins(cluster, component, source, start, end)
    named = [uids[row] for row in rows]
    groups = {uids[row]: joined.get(leader, (leader,)) for row, leader in zip(rows, cluster.tolist(), strict=True)}
    founds = np.array([leader not in joined for leader in cluster.tolist()], bool)
    founding = np.zeros(len(uids), bool)
    founding[rows] = founds
    first = np.array([groups[uid][0] for uid in named], np.int64)
    together = overlapping_touches(source, start, end)
    # without moments of several sensors a touch is drawn by its group
    moment, met = (first, {}) if (together == cluster).all() else join_moments(together, first, founds, source, start)
    moment_of = {uid: named[leader] for uid, leader in zip(named, moment.tolist(), strict=True)}
    return Groups(
        roots,
        [named[groups[root][0]] if root in groups else root for root in roots],
        [moment_of.get(root, root) for root in roots],
        founding,
        {uid: tuple(named[other] for other in those[1:]) for uid, those in groups.items() if len(those) > 1},
        {named[row]: tuple(named[other] for other in those) for row, those in met.items()},
    )
