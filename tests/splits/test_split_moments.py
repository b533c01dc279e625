"""What several sensors of one recording took at one moment stays on one side, and the audit finds what does not."""

import numpy as np
import pytest
from hypothesis import given
from split_cases import MemoryStore, parts, trajectories
from test_split_laws import FEW, assigned, held, stores
from test_split_twins import SECOND, recorded

from tactiledata.splits.assign import assign
from tactiledata.splits.audit import audit
from tactiledata.splits.make import make_split
from tactiledata.splits.moment_leaks import _overlapping, parted_moments, parted_recordings
from tactiledata.splits.moments import SIDES
from tactiledata.splits.options import EXCLUDED, PARTITIONS, SplitOptions
from tactiledata.splits.twins import ABSOLUTE_NS

NONE = SplitOptions.checked(hold_out="none")


def fingers(n=60, lag=SECOND // 2, sensors="AB", **changes):
    """Touches of several fingers, each finger a little later than the one before, all in the same recordings."""
    return [
        {**row, "uid": f"{finger.lower()}{k:015x}", "trajectory": f"{finger}{k}", "sensor": finger,
         "start_ns": row["start_ns"] + place * lag, "end_ns": row["end_ns"] + place * lag, **changes}
        for place, finger in enumerate(sensors)
        for k, row in enumerate(recorded(n))
    ]  # fmt: skip


def side_of(table):
    """Side by trajectory's name, None where it is in no part."""
    pairs = zip(table["trajectory"].to_pylist(), table["partition"].to_pylist(), strict=True)
    return {name: SIDES.get(part) for name, part in pairs}


def codes(*names):
    return np.array([PARTITIONS.index(name) if name else -1 for name in names], np.int64)


def test_fingers_of_one_moment_stand_together(tmp_path):
    """Two sensors that touch at one moment of one recording are drawn as one, and the audit finds nothing."""
    store = MemoryStore(tmp_path, trajectories(fingers()))
    make_split(store, hold_out="none")
    side = side_of(assign(store.table, NONE, {}))
    assert all(side[f"A{k}"] == side[f"B{k}"] for k in range(60))
    assert set(side.values()) == {"train", "val", "test"}
    assert audit(store, images=False).findings == ()


@pytest.mark.parametrize("lag", [2 * SECOND, 4 * SECOND])
def test_fingers_one_after_the_other_are_drawn_alone(lag):
    """Negative control: where one finger ends before the other begins, each touch is drawn by its own uid."""
    table = trajectories(fingers(lag=lag))
    drawn = assign(table, NONE, {})
    assert drawn["group"].to_pylist() == table["uid"].to_pylist()
    side = side_of(drawn)
    assert any(side[f"A{k}"] != side[f"B{k}"] for k in range(60))


def test_other_recordings_of_the_same_time_are_drawn_alone():
    """Negative control: two rigs that run at one time, each with its own recordings, are not joined."""
    one = recorded()
    other = [{**row, "uid": f"b{k:015x}", "source": row["source"] + 100, "sensor": "B"} for k, row in enumerate(one)]
    table = trajectories([*one, *other])
    assert assign(table, NONE, {})["group"].to_pylist() == table["uid"].to_pylist()


def test_a_held_out_finger_is_tested_at_moments_that_nobody_learned_from():
    """Where the other finger is learned from, the held-out one is in no part; elsewhere it is unseen."""
    drawn = assign(trajectories(fingers()), NONE, {"sensor": ("B",)})
    where = {row["trajectory"]: row["partition"] for row in drawn.to_pylist()}
    beside = {part: {where[f"B{k}"] for k in range(60) if where[f"A{k}"] == part} for part in ("train", "val", "test")}
    assert beside == {"train": {EXCLUDED}, "val": {EXCLUDED}, "test": {"test_unseen"}}


def test_a_copy_with_another_finger_gives_way(tmp_path):
    """A later copy of a recording that holds one more finger goes where the moment is, and moves nobody."""
    rows = fingers(sensors="A")
    before = parts(assign(trajectories(rows), NONE, {}))
    copy = [{**row, "uid": f"c{row['uid'][1:]}", "source": row["source"] + 1000} for row in fingers(sensors="A")]
    other = [{**row, "source": row["source"] + 1000} for row in fingers(sensors="AB") if row["sensor"] == "B"]
    store = MemoryStore(tmp_path, trajectories([*rows, *copy, *other]))
    make_split(store, hold_out="none")
    after = parts(assign(store.table, NONE, {}))
    assert {uid: after[uid] for uid in before} == before
    assert all(after[f"b{k:015x}"] == after[f"c{k:015x}"] == before[f"a{k:015x}"] for k in range(60))
    assert audit(store, images=False).findings == ()
    held_out = parts(assign(store.table, NONE, {"sensor": ("A",)}))
    assert {held_out[f"b{k:015x}"] for k in range(60)} == {EXCLUDED, "test"}


def test_a_finger_between_two_moments_is_in_no_part():
    """A later recording that holds touches of train and of test at one moment is in no part, with whatever repeats
    its touches.
    """
    rows = [{**row, "uid": f"a{k:015x}"} for k, row in enumerate(recorded()) if k % 2 == 0]
    shifted = [{**row, "uid": f"b{k:015x}", "sensor": "B", "start_ns": row["start_ns"] + 5 * SECOND,
                "end_ns": row["end_ns"] + 5 * SECOND} for k, row in enumerate(rows)]  # fmt: skip
    before = assign(trajectories([*rows, *shifted]), NONE, {})["partition"].to_pylist()
    half = len(rows)
    apart = next(k for k in range(half) if before[k] != before[half + k])
    # a recording that took both touches, and a third finger's, which lasts from the one to the other
    again = [{**rows[apart], "uid": "e" * 16, "source": 500}, {**shifted[apart], "uid": "f" * 16, "source": 500}]
    third = {**rows[apart], "uid": "d" * 16, "sensor": "C", "source": 500, "end_ns": shifted[apart]["end_ns"]}
    repeated = {**third, "uid": "c" * 16, "source": 501}
    after = parts(assign(trajectories([*rows, *shifted, *again, third, repeated]), NONE, {}))
    assert [after[letter * 16] for letter in "efdc"] == [EXCLUDED] * 4
    assert [after[row["uid"]] for row in [*rows, *shifted]] == before


def test_a_finger_between_two_moments_of_one_side_goes_with_the_earlier():
    """Where both moments are on one side, the newcomer is drawn by the first of them."""
    rows = [{**row, "uid": f"a{k:015x}"} for k, row in enumerate(recorded())]
    before = assign(trajectories(rows), NONE, {})["partition"].to_pylist()
    alike = next(k for k in range(59) if before[k] == before[k + 1])
    again = [{**rows[alike + step], "uid": letter * 16, "source": 500} for step, letter in ((0, "e"), (1, "f"))]
    third = {**rows[alike], "uid": "d" * 16, "sensor": "C", "source": 500, "end_ns": rows[alike + 1]["end_ns"]}
    drawn = assign(trajectories([*rows, *again, third]), NONE, {}).to_pylist()
    assert [(row["group"], row["partition"]) for row in drawn[-3:]] == [
        (rows[alike]["uid"], before[alike]),
        (rows[alike + 1]["uid"], before[alike]),
        (rows[alike]["uid"], before[alike]),
    ]


@pytest.mark.parametrize(
    ("one", "other", "is_leak"),
    [("train", "test", 1), ("val", "test_unseen", 1), ("train", "val", 1), ("test", "test_unseen", 0),
     ("train", "train", 0), ("train", None, 0)],
)  # fmt: skip
def test_a_moment_on_two_sides_is_a_leak(one, other, is_leak):
    """Two sensors of one moment on two sides are named; both tests are one side, and what is in no part is none."""
    table = trajectories([{"sensor": "A", "start_ns": 0}, {"sensor": "B", "start_ns": 4_999}, {"start_ns": 20_000}])
    found = parted_moments(table, codes(one, other, "val"))
    assert [(finding.code, finding.severity, finding.count) for finding in found] == [
        ("moment-in-two-parts", "damage", 1)
    ] * is_leak
    if is_leak:
        assert f"'t0' of sensor A ({one}) and 't1' of sensor B ({other})" in found[0].message


@pytest.mark.parametrize(
    "changes", [{"start_ns": 5_000}, {"sensor": "A"}, {"source": 1}, {"parent": "p"}],
    ids=["later", "same sensor", "other recording", "derived"],
)  # fmt: skip
def test_what_is_no_common_moment(changes):
    """Negative control: one after the other, one sensor (another finding), other recordings and derived ones."""
    table = trajectories([{"sensor": "A", "start_ns": 0}, {"sensor": "B", "start_ns": 0, **changes}])
    assert parted_moments(table, codes("train", "test")) == []


def test_an_edited_split_is_reported(tmp_path):
    """A split of before, which parts two fingers, is told with the moment and with what the draw says now."""
    store = MemoryStore(tmp_path, trajectories(fingers()))
    make_split(store, hold_out="none")
    # what was drawn finger by finger: the second finger under a clock of its own
    alone = trajectories([row | {"source": row["source"] + 100 * (row["sensor"] == "B")} for row in fingers()])
    drawn_alone = MemoryStore(tmp_path, alone)
    make_split(drawn_alone, hold_out="none", replace=True)
    codes_found = {finding.code for finding in audit(store, images=False).leaks}
    assert codes_found == {"moment-in-two-parts", "not-as-drawn"}


@pytest.mark.parametrize(
    ("clock", "changes", "count"),
    [(ABSOLUTE_NS, {}, 2), (0, {}, 0), (ABSOLUTE_NS, {"sensor": "A"}, 0), (ABSOLUTE_NS, {"source": 0}, 0),
     (ABSOLUTE_NS, {"source": 0, "sensor": "A"}, 0),
     (ABSOLUTE_NS, {"start_ns": ABSOLUTE_NS + 5_000, "end_ns": ABSOLUTE_NS + 9_000}, 0),
     (ABSOLUTE_NS, {"parent": "p"}, 0), (ABSOLUTE_NS, {"sensor": ""}, 0), (ABSOLUTE_NS, {"end_ns": ABSOLUTE_NS}, 0),
     (ABSOLUTE_NS, {"start_ns": ABSOLUTE_NS + 50, "end_ns": ABSOLUTE_NS + 10}, 0)],
    ids=["two", "boot clock", "twin", "one recording", "one place", "later", "derived", "unnamed", "empty", "reversed"],
)  # fmt: skip
def test_moments_of_two_recordings_are_a_warning(clock, changes, count):
    """Sensors of two recordings at one absolute time, on two sides, are a warning: they may be two rigs."""
    table = trajectories([{"start_ns": clock}, {"sensor": "B", "source": 1, "start_ns": clock, **changes}])
    found = parted_recordings(table, codes("train", "test"))
    assert [(f.code, f.severity, f.count) for f in found] == [("moment-in-two-recordings", "warning", count)] * (
        count > 0
    )
    assert parted_recordings(table, codes("test_unseen", "test")) == []


def test_places_and_sides_are_told_apart():
    """One sensor in the first and the fifth recording, on two sides, is no matter of two sensors."""
    rows = [{"source": 0}, {"source": 4, "start_ns": ABSOLUTE_NS}, {"sensor": "B", "start_ns": 2 * ABSOLUTE_NS}]
    rows[0]["start_ns"] = ABSOLUTE_NS
    assert parted_recordings(trajectories(rows), codes("val", "train", "train")) == []


def test_a_twin_hides_no_other_sensor():
    """Beside a copy of itself on another side, a touch of another sensor is counted, and so are all three."""
    table = trajectories([{"source": k, "sensor": sensor, "start_ns": ABSOLUTE_NS} for k, sensor in enumerate("AAB")])
    assert [finding.count for finding in parted_recordings(table, codes("train", "val", "test"))] == [3]


def test_a_second_touch_of_one_place_hides_no_other_sensor():
    """Beside one of its own recording and sensor on another side, a touch of another recording and sensor is met."""
    rows = [{"sensor": "A"}, {"sensor": "A"}, {"source": 1, "sensor": "B"}]
    table = trajectories([{**row, "start_ns": ABSOLUTE_NS} for row in rows])
    assert [finding.count for finding in parted_recordings(table, codes("train", "val", "test"))] == [3]


@pytest.mark.parametrize(("pairs", "named"), [(1, "'t0', 't1'"), (2, "'t0', 't1', 't2' …")])
def test_three_touches_of_two_recordings_are_named(pairs, named):
    """All are counted; a sign says that there are more than are named."""
    rows = [{"source": side, "sensor": "AB"[side], "start_ns": ABSOLUTE_NS + 10_000 * pair}
            for pair in range(pairs) for side in (0, 1)]  # fmt: skip
    (found,) = parted_recordings(trajectories(rows), codes(*["train", "test"] * pairs))
    assert found.message.startswith(f"{2 * pairs} trajectories ({named}) overlap in time")


def test_three_touches_of_three_recordings_are_all_named():
    """No sign where none is left."""
    rows = [{"source": k, "sensor": "ABC"[k], "start_ns": ABSOLUTE_NS} for k in range(3)]
    (found,) = parted_recordings(trajectories(rows), codes("train", "val", "test"))
    assert found.message.startswith("3 trajectories ('t0', 't1', 't2') overlap in time")


def test_intervals_of_one_place_are_counted():
    """Each interval's overlaps in its own place, itself included, as comparing all pairs says; touching is none."""
    start = np.array([0, 3, 10, 30, 31, 7, 100, 5])
    end = np.array([5, 9, 12, 33, 40, 11, 101, 7])
    for place in (np.zeros(8, int), np.array([3, 3, 3, -1, -1, 3, 8, 8]), np.arange(8) % 4, np.arange(8)[::-1]):
        pairs = (place[:, None] == place) & (np.maximum(start[:, None], start) < np.minimum(end[:, None], end))
        assert _overlapping(place, start, end).tolist() == pairs.sum(axis=1).tolist()


def test_only_sensors_of_the_same_moment_make_it_one_of_several():
    """Touches of one sensor that overlap on two sides are another finding, whatever lies before and after them."""
    rows = [{"sensor": "B"}, {"sensor": "A"}, {"sensor": "A", "start_ns": 10_000}, {"sensor": "C"}]
    rows = [{"start_ns": 10_000 * k, **row} for k, row in enumerate(rows)]
    assert parted_moments(trajectories(rows), codes("train", "train", "test", "val")) == []


@pytest.mark.parametrize("child", ["0" * 16, "f" * 16])
def test_a_derived_touch_has_no_say_in_the_side_of_a_moment(child):
    """Where a held-out finger is unseen, another finger of a later recording is in no part, with what derives of it."""
    rows = [{**row, "uid": f"a{k:015x}"} for k, row in enumerate(recorded())]
    drawn = assign(trajectories(rows), NONE, {})["partition"].to_pylist()
    learned = drawn.index("train")
    again = {**rows[learned], "uid": "b" * 16, "source": 500}
    other = {**again, "uid": "c" * 16, "sensor": "B"}
    derived = {**other, "uid": child, "parent": other["uid"]}
    # a touch of a third finger, so that something is left to learn from
    third = [
        {**row, "uid": f"d{k:015x}", "source": 600 + k, "sensor": "C"}
        for k, row in enumerate(recorded(clock=ABSOLUTE_NS + 10**15))
    ]
    where = parts(assign(trajectories([*rows, again, other, derived, *third]), NONE, {"sensor": ("A",)}))
    assert {where[row["uid"]] for row in rows} == {where["b" * 16]} == {"test_unseen"}
    assert where["c" * 16] == where[child] == EXCLUDED


def test_a_touch_over_two_of_its_sensor_is_drawn_by_the_earlier():
    """A later recording of one sensor that bridges two touches of one side goes with the first of them."""
    rows = [{**row, "uid": f"a{k:015x}"} for k, row in enumerate(recorded())]
    before = assign(trajectories(rows), NONE, {})["partition"].to_pylist()
    alike = next(k for k in range(59) if before[k] == before[k + 1])
    bridge = {**rows[alike], "uid": "b" * 16, "source": 500, "end_ns": rows[alike + 1]["end_ns"]}
    found = assign(trajectories([*rows, bridge]), NONE, {}).to_pylist()[-1]
    assert (found["group"], found["partition"]) == (rows[alike]["uid"], before[alike])


@FEW
@given(stores())
def test_the_warning_agrees_with_all_pairs(rows):
    """It counts what overlaps one of another recording and sensor on another side, as comparing all pairs says."""
    table = trajectories([{**row, "start_ns": ABSOLUTE_NS + row["start_ns"] % ABSOLUTE_NS} for row in rows])
    rows = table.to_pylist()
    part = np.arange(len(rows)) % (len(PARTITIONS) + 1) - 1

    def is_met(one, other):
        a, b = rows[one], rows[other]
        return (
            a["source"] != b["source"] and a["sensor"] != b["sensor"]
            and max(a["start_ns"], b["start_ns"]) < min(a["end_ns"], b["end_ns"])
            and SIDES[PARTITIONS[part[one]]] != SIDES[PARTITIONS[part[other]]]
        )  # fmt: skip

    taken = [k for k, row in enumerate(rows) if part[k] >= 0 and not row["parent"] and row["sensor"]]
    count = sum(any(is_met(one, other) for other in taken) for one in taken)
    assert [finding.count for finding in parted_recordings(table, part)] == ([count] if count else [])


@FEW
@given(stores(orphans=True), held)
def test_one_moment_of_a_recording_is_on_one_side(rows, held_out):
    """Recorded trajectories of one recording that overlap in time are on one side or in no part, whoever took them."""
    table = assigned(rows, held_out)
    if table is None:
        return
    where = parts(table)
    full = [row for row in trajectories(rows).to_pylist() if not row["parent"]]
    for one in full:
        for other in full:
            if one["source"] == other["source"] and max(one["start_ns"], other["start_ns"]) < min(
                one["end_ns"], other["end_ns"]
            ):
                sides = {SIDES.get(where[row["uid"]]) for row in (one, other)} - {None}
                assert len(sides) <= 1
    store_part = np.array([PARTITIONS.index(p) if p in PARTITIONS else -1 for p in table["partition"].to_pylist()])
    assert parted_moments(trajectories(rows), store_part) == []
