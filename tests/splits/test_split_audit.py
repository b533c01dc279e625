"""The audit finds each kind of leak that is planted in the tables, and nothing in a clean split."""

import hashlib
import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st
from split_cases import MemoryStore, many, replaced, trajectories

from tactiledata.contract.sealed import sealed_json
from tactiledata.errors import MissingSplit
from tactiledata.splits.audit import audit
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import load_split
from tactiledata.splits.twins import ABSOLUTE_NS


def audited(store):
    return {finding.code: finding for finding in audit(store, images=False).findings}


def forged(store, change, name="default"):
    """A split whose table was changed and whose document vouches for the change."""
    table, document = store.split_path(name), store.split_path(name, ".json")
    rows = pq.read_table(table).to_pylist()
    rows = change(rows) or rows
    pq.write_table(pa.Table.from_pylist(rows, schema=pq.read_schema(table)), table)
    content = json.loads(document.read_text())
    content["table"] |= {"sha256": hashlib.sha256(table.read_bytes()).hexdigest(), "rows": len(rows)}
    document.write_bytes(sealed_json(content))


def rows_of(store, part):
    table = load_split(store, "default").table.to_pylist()
    return [number for number, row in enumerate(table) if row["partition"] == part]


@pytest.fixture
def store(tmp_path):
    rows = [*many(200), *({**row, "uid": f"d{k:015x}", "parent": f"{k:016x}"} for k, row in enumerate(many(50)))]
    store = MemoryStore(tmp_path, trajectories(rows))
    make_split(store)
    return store


def test_a_clean_split_passes(store):
    """A split as made, derived trajectories and held-out units among it, has no finding at all."""
    report = audit(store, images=False)
    assert report.findings == ()
    assert report.leaks == ()
    assert report.checked == {"trajectories": 250, "frames": 750}
    assert "no leak found" in report.lines()[0]


def test_empty_parts_are_named(tmp_path):
    """Two groups cannot fill three parts: the audit finds no leak, and names the empty parts beside that."""
    store = MemoryStore(tmp_path, trajectories(many(2)))
    made = make_split(store, hold_out="none", replace=True)
    empty = [part for part in ("train", "val", "test") if not made.counts[part].trajectories]
    assert empty
    report = audit(store, images=False)
    assert [(finding.code, finding.count) for finding in report.findings] == [("split-empty-part", len(empty))]
    assert report.leaks == ()
    assert f"no leak found, but {' and '.join(empty)} ha" in report.lines()[0]
    # a part that nobody asked for is not missing
    make_split(store, hold_out="none", fractions=(1, 0, 0), replace=True)
    assert audit(store, images=False).findings == ()


def test_a_part_without_frames_is_named(store):
    """Trajectories whose frames are all outside the contact filter leave a part as empty as none."""
    rows = rows_of(store, "val")
    owner = store.frame_table["trajectory"].to_numpy()
    force = np.where(np.isin(owner, rows), 0.0, 5.0)
    store.frame_table = replaced(store.frame_table, contact_force=force)
    report = audit(store, images=False)
    assert "val has trajectories and no frame" in report.lines()[0]
    assert report.leaks == ()


@few(25)
@given(
    st.lists(
        st.tuples(st.integers(0, 2), st.sampled_from("ABCDE"), st.integers(0, 9), st.integers(-1, 20)),
        min_size=3,
        max_size=30,
    ),
    st.integers(0, 5),
    st.sampled_from([0, ABSOLUTE_NS]),
)
def test_whatever_is_split_passes(tmp_path_factory, spec, seed, clock):
    """Any store that can be split, overlaps, twins and chains of parents included, passes its audit."""
    rows = [
        {"source": s, "sensor": unit, "start_ns": clock + 1000 * t, "parent": f"{p:016x}" if 0 <= p < k else ""}
        for k, (s, unit, t, p) in enumerate(spec)
    ]
    store = MemoryStore(tmp_path_factory.mktemp("any"), trajectories(rows))
    try:
        make_split(store, seed=seed)
    except ValueError:
        return
    assert audit(store, images=False).leaks == ()


def test_a_touch_under_two_names_is_found(store):
    """Two overlapping trajectories of one source and sensor are found, when one of them is in another part."""
    train, test = rows_of(store, "train")[0], rows_of(store, "test")[0]
    rows = store.table.to_pylist()
    same = {key: rows[train][key] for key in ("source", "sensor", "start_ns", "end_ns")}
    rows[test] |= same
    store.table = trajectories(rows)
    found = audited(store)["touch-in-two-parts"]
    assert found.severity == "damage"
    assert f"'t{train}' (train) and 't{test}' (test)" in found.message


@pytest.mark.parametrize(
    ("clock", "sensor", "is_leak"), [(ABSOLUTE_NS, "A", True), (0, "A", False), (ABSOLUTE_NS, "", False)]
)
def test_a_touch_in_two_recordings_is_found(store, clock, sensor, is_leak):
    """A moment of one sensor in two recordings is found by absolute times of a named sensor, and only by those."""
    train, test = rows_of(store, "train")[0], rows_of(store, "test")[0]
    rows = store.table.to_pylist()
    for row, source in ((train, 900), (test, 901)):
        rows[row] |= {"source": source, "sensor": sensor, "start_ns": clock + 10**9, "end_ns": clock + 2 * 10**9}
    store.table = trajectories(rows)
    found = audited(store)
    assert ("touch-in-two-parts" in found) == is_leak
    if is_leak:
        text = found["touch-in-two-parts"].message
        assert f"'t{train}' of recording 900 (train) and 't{test}' of recording 901 (test)" in text


def test_neighbouring_touches_are_no_leak(store):
    """One touch that starts where another ends is another touch; so is the same time on another sensor or source."""
    train, test = rows_of(store, "train")[0], rows_of(store, "test")[0]
    rows = store.table.to_pylist()
    rows[test] |= {key: rows[train][key] for key in ("source", "sensor")}
    rows[test] |= {"start_ns": rows[train]["end_ns"], "end_ns": rows[train]["end_ns"] + 1}
    store.table = trajectories(rows)
    assert "touch-in-two-parts" not in audited(store)


def test_children_away_from_their_parents_are_found(store):
    """A derived trajectory that was moved into another part than its parent is found."""
    child = next(n for n in rows_of(store, "train") if n >= 200)

    def change(rows):
        rows[child]["partition"] = "test"

    forged(store, change)
    found = audited(store)
    assert found["derived-away-from-parent"].count == 1
    assert "drawn for train" in found["not-as-drawn"].message


def test_frames_away_from_their_parent_frames_are_found(store):
    """A test frame that says it was derived from a train frame; a parent that the store does not hold is a warning."""
    train, test = rows_of(store, "train")[0], rows_of(store, "test")[0]
    parents = np.full(store.n_frames, -1)
    parents[3 * test] = 3 * train
    parents[3 * train + 1] = 3 * train
    store.frame_table = replaced(store.frame_table, parent_frame=parents)
    found = audited(store)
    assert set(found) == {"derived-frame-away-from-parent"}
    assert f"frame {3 * test} (test) from frame {3 * train} (train)" in found["derived-frame-away-from-parent"].message
    parents[3 * test] = 10**6
    store.frame_table = replaced(store.frame_table, parent_frame=parents)
    assert audited(store)["unknown-parent-frame"].severity == "warning"


def test_held_out_units_elsewhere_are_found(store):
    """A trajectory of the held-out sensor that was moved to train is found."""
    unseen = rows_of(store, "test_unseen")[0]

    def change(rows):
        rows[unseen]["partition"] = "train"

    forged(store, change)
    assert audited(store)["held-out-sensor-seen"].count == 1


def test_a_renamed_unit_is_found(store):
    """A split's table that gives a trajectory another sensor than the store."""

    def change(rows):
        rows[0]["sensor"] = "another"

    forged(store, change)
    assert audited(store)["unit-renamed"].count == 1


def test_a_trajectory_in_two_parts_is_found(store):
    """A uid that stands twice, in train and in test."""
    test = rows_of(store, "test")[0]
    forged(store, lambda rows: [*rows, {**rows[test], "partition": "train"}])
    found = audited(store)
    assert found["shared-trajectory"].count == 1
    assert "split-out-of-date" in found


def test_trajectories_that_the_split_does_not_know_are_found(store):
    """A store that has grown since."""
    store.table = trajectories([*store.table.to_pylist(), {"uid": "f" * 16, "source": 5000}])
    assert "1 new trajectory" in audited(store)["split-out-of-date"].message
    assert "out of date: the store holds other" in audit(store, images=False).lines()[0]
    assert "no leak found" in audit(store, images=False).lines()[0]


def test_changed_files_are_found(store):
    """A table changed under its document is a leak by itself: nothing can be said of it."""
    store.split_path("default").write_bytes(b"PAR1")
    report = audit(store, images=False)
    assert [finding.code for finding in report.leaks] == ["split-changed"]
    assert "nothing can be said about leaks" in report.lines()[0]
    assert report.document()["leaks"] == 1


def test_images_of_the_same_bytes_are_found(store):
    """Equal CRC and length in train and test are one image; equal CRC alone, or within one part, is none."""
    train, test = rows_of(store, "train")[:2], rows_of(store, "test")
    crc, length = np.arange(store.n_frames) * 7919, 1000 + np.arange(store.n_frames)
    crc[3 * test[0]] = crc[3 * train[0]]
    crc[3 * train[1]], length[3 * train[1]] = crc[3 * train[0] + 1], length[3 * train[0] + 1]
    store.frame_table = replaced(store.frame_table, crc32c=crc, length=length)
    assert audited(store) == {}
    length[3 * test[0]] = length[3 * train[0]]
    store.frame_table = replaced(store.frame_table, crc32c=crc, length=length)
    found = audited(store)["identical-image"]
    assert found.count == 1
    sources = [store.table["source"][row].as_py() for row in (train[0], test[0])]
    assert all(f"of log{source}/t" in found.message for source in sources)


def test_raw_frames_are_not_taken_for_equal(store):
    """Raw frames have no length in the heap: their CRC alone proves nothing and is not used."""
    n = store.n_frames
    store.frame_table = replaced(store.frame_table, crc32c=np.zeros(n, int), length=np.zeros(n, int))
    assert audited(store) == {}


def test_a_split_that_is_not_there_is_wrong_usage(tmp_path):
    """A split that is not there gives an error, not a clean report."""
    with pytest.raises(MissingSplit):
        audit(MemoryStore(tmp_path, trajectories(many(5))))


def test_frames_that_the_split_leaves_out_leak_nothing(store):
    """A copy outside the force bounds is in no part."""
    train, test = rows_of(store, "train")[0], rows_of(store, "test")[0]
    crc, length = np.arange(store.n_frames), np.full(store.n_frames, 1000)
    crc[3 * test] = crc[3 * train]
    force = np.full(store.n_frames, 5.0)
    force[3 * test] = 0.5
    store.frame_table = replaced(store.frame_table, crc32c=crc, length=length, contact_force=force)
    assert audited(store) == {}
