"""Twins of one recording stay in one part, whoever comes later moves nobody, and strangers are not joined."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st
from split_cases import MemoryStore, many, parts, trajectories

from tactiledata.splits.assign import assign
from tactiledata.splits.audit import audit
from tactiledata.splits.groups import group_trajectories
from tactiledata.splits.make import make_split
from tactiledata.splits.options import EXCLUDED, SplitOptions
from tactiledata.splits.twins import ABSOLUTE_NS, join_twins

NONE = SplitOptions.checked(hold_out="none")
SECOND = 10**9


def recorded(n=60, clock=ABSOLUTE_NS, per_source=5):
    """Touches of 2 s every 10 s, some to a recording."""
    return [
        {**row, "source": k // per_source, "sensor": "A", "start_ns": clock + 10 * k * SECOND,
         "end_ns": clock + (10 * k + 2) * SECOND}
        for k, row in enumerate(many(n))
    ]  # fmt: skip


def copied(rows, shift=SECOND, **changes):
    """The touches in recordings of their own, each cut a little differently."""
    return [
        {**row, "uid": f"c{k:015x}", "source": row["source"] + 1000, "end_ns": row["end_ns"] + shift, **changes}
        for k, row in enumerate(rows)
    ]


@pytest.mark.parametrize("only", [slice(None), slice(0, 60, 3)], ids=["whole", "damaged"])
def test_a_copy_stands_with_its_original(tmp_path, only):
    """An edited or damaged copy is dealt out as its original was, and the audit finds nothing."""
    rows = recorded()
    before = parts(assign(trajectories(rows), NONE, {}))
    twins = copied(rows)[only]
    store = MemoryStore(tmp_path, trajectories([*rows, *twins]))
    make_split(store, hold_out="none")
    after = parts(assign(store.table, NONE, {}))
    assert {uid: after[uid] for uid in before} == before
    for twin in twins:
        assert after[twin["uid"]] == before[f"{int(twin['uid'][1:], 16):016x}"]
    assert set(before.values()) == {"train", "val", "test"}
    assert audit(store, images=False).findings == ()


def test_a_copy_in_the_very_next_recording_stands_with_its_original():
    """A store of one recording and its copy alone: the second follows the first."""
    rows = recorded(per_source=60)
    twins = [{**row, "source": 1} for row in copied(rows)]
    found = group_trajectories(trajectories([*rows, *twins])).group
    assert found == [row["uid"] for row in trajectories(rows).to_pylist()] * 2


@pytest.mark.parametrize(("shift", "is_twin"), [(0, True), (1, False)])
def test_unnamed_sensors_are_told_by_equal_spans(shift, is_twin):
    """A sensor without a name is called otherwise in each recording: twins have equal spans, to the nanosecond."""
    rows = [{**row, "sensor": "unknown-1"} for row in recorded()]
    found = group_trajectories(trajectories([*rows, *copied(rows, shift, sensor="unknown-2")])).group
    assert (found[60:] == found[:60]) == is_twin


@pytest.mark.parametrize(
    ("clock", "changes"),
    [(0, {}), (3600 * SECOND, {}), (ABSOLUTE_NS, {"sensor": "B"}), (ABSOLUTE_NS, {"sensor": ""})],
    ids=["index clock", "boot clock", "another sensor", "unnamed"],
)
def test_strangers_are_not_joined(clock, changes):
    """Negative control: clocks that count from a start, and other sensors, join nobody."""
    rows = recorded(clock=clock)
    if changes.get("sensor") == "":
        rows = [{**row, "sensor": ""} for row in rows]
    table = trajectories([*rows, *copied(rows, **changes)])
    assert group_trajectories(table).group == table["uid"].to_pylist()


def test_a_bridge_between_two_parts_is_in_none(tmp_path):
    """A later touch that spans touches of train and test moves neither: it and its children are left out."""
    rows = recorded()
    before = parts(assign(trajectories(rows), NONE, {}))
    apart = next(k for k in range(59) if before[f"{k:016x}"] != before[f"{k + 1:016x}"])
    alike = next(k for k in range(59) if before[f"{k:016x}"] == before[f"{k + 1:016x}"])
    bridges = [
        {**rows[k], "uid": f"b{k:015x}", "source": 2000, "end_ns": rows[k + 1]["end_ns"]} for k in (apart, alike)
    ]
    child = {**rows[apart], "uid": "d" * 16, "source": 2001, "parent": f"b{apart:015x}"}
    store = MemoryStore(tmp_path, trajectories([*rows, *bridges, child]))
    report = make_split(store, hold_out="none")
    after = parts(assign(store.table, NONE, {}))
    assert {uid: after[uid] for uid in before} == before
    assert after[f"b{apart:015x}"] == after["d" * 16] == EXCLUDED
    assert after[f"b{alike:015x}"] == before[f"{alike:016x}"]
    assert sum(note.startswith("in no part") for note in report.notes) == 2
    assert audit(store, images=False).leaks == ()


def test_a_copy_with_a_held_out_unit_moves_nobody():
    """A copy that names a held-out indenter, while the original does not, is in no part; the original stays."""
    rows = [{**row, "indenter": "ball"} for row in recorded()]
    before = parts(assign(trajectories(rows), NONE, {}))
    after = parts(assign(trajectories([*rows, *copied(rows, indenter="star")]), NONE, {"indenter": ("star",)}))
    assert {uid: after[uid] for uid in before} == before
    assert {part for uid, part in after.items() if uid[0] == "c"} == {EXCLUDED}


spans = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 20), st.integers(1, 6)), min_size=1, max_size=25)


@few(60)
@given(spans)
def test_joining_agrees_with_its_slow_twin(found):
    """Each cluster joins the groups of all earlier clusters that it overlaps, as comparing all pairs says."""
    source, start, length = (np.array(column, np.int64) for column in zip(*sorted(found), strict=True))
    end = start + length
    n = len(source)

    def meets(i, j):
        return max(start[i], start[j]) < min(end[i], end[j])

    cluster = np.arange(n)
    for _ in range(n):
        for i in range(n):
            for j in range(n):
                if source[i] == source[j] and meets(i, j):
                    cluster[i] = cluster[j] = min(cluster[i], cluster[j])
    groups = {}
    for leader in sorted(set(cluster.tolist()), key=lambda row: (source[row], row)):
        groups[leader] = {
            group
            for j in range(n)
            if source[j] < source[leader] and any(meets(i, j) for i in np.flatnonzero(cluster == leader))
            for group in groups[cluster[j]]
        } or {leader}
    joined = join_twins(cluster, np.zeros(n, np.int64), source, start, end)
    assert {leader: set(joined.get(leader, (leader,))) for leader in groups} == groups
