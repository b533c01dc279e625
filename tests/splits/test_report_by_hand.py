"""What is said of a split: counts, shares, empty parts, holes in strata, and frames that are left out."""

import numpy as np
import pyarrow as pa
import pytest
from split_cases import MemoryStore, frames, many, trajectories

from tactiledata.contract.take import FrameFlag
from tactiledata.errors import StoreError
from tactiledata.splits.assign import assign
from tactiledata.splits.options import EXCLUDED, PARTITIONS, SHARES, SplitOptions
from tactiledata.splits.report import (
    Count,
    SplitReport,
    Stratum,
    _excluded,
    _part_notes,
    _thin_strata,
    count_parts,
    count_strata,
    notes_on,
)
from tactiledata.splits.select import check_force_filter, frames_per_trajectory, taken_frames
from tactiledata.splits.suggest import suggest_split

NONE = SplitOptions.checked(hold_out="none")
ALL_PARTS = (*PARTITIONS, EXCLUDED)


def dealt(*rows):
    """A split's table of (partition, frames, sensor, indenter)."""
    table = assign(
        trajectories([{"source": k, "sensor": s, "indenter": i} for k, (_, _, s, i) in enumerate(rows)]), NONE, {}
    )
    table = table.set_column(table.column_names.index("partition"), "partition", pa.array([row[0] for row in rows]))
    return table.set_column(
        table.column_names.index("frames"), "frames", pa.array([row[1] for row in rows], pa.int64())
    )


def counts(**given):
    return {part: Count(*given.get(part, (0, 0))) for part in ALL_PARTS}


def test_trajectories_and_frames_are_counted_by_part():
    """Two in train with 3 and 4 frames, one in test without any, one in none; parts without any are zeros."""
    table = dealt(("train", 3, "A", "x"), ("train", 4, "B", "x"), ("test", 0, "A", "x"), (EXCLUDED, 5, "A", "x"))
    assert count_parts(table) == counts(train=(2, 7), test=(1, 0), excluded=(1, 5))
    assert Count(2, 7).document() == {"trajectories": 2, "frames": 7}


def test_strata_are_counted_by_units():
    """A stratum for each combination of units that there is, in order, with zeros where it has nothing."""
    table = dealt(("train", 3, "B", "x"), ("train", 4, "A", "y"), ("test", 1, "A", "y"), ("train", 2, "A", "y"))
    first, second = count_strata(table, ("sensor", "indenter"))
    assert (first.label, second.label) == ("sensor A, indenter y", "sensor B, indenter x")
    assert first.counts == counts(train=(2, 6), test=(1, 1))
    assert second.counts == counts(train=(1, 3))
    assert count_strata(table, ()) == ()
    assert Stratum({"sensor": ""}, {}).label == "sensor (unnamed)"


def test_a_report_for_people_and_programs():
    """Shares of all trajectories; excluded ones have a line only where there are some; the notes behind."""
    report = SplitReport("x", NONE, {"sensor": ("A",)}, counts(train=(3, 9), test=(1, 1)), (), ("a note",))
    assert [line.split() for line in report.lines()[1:3]] == [
        ["train", "3", "trajectories", "(75.0%),", "9", "frames"],
        ["val", "0", "trajectories", "(0.0%),", "0", "frames"],
    ]  # fmt: skip
    assert report.lines()[0] == "split 'x': held out: sensor A"
    assert len(report.lines()) == 6
    assert report.lines()[-1] == "- a note"
    with_excluded = SplitReport("x", NONE, {}, counts(train=(3, 9), excluded=(1, 0)), (), ())
    assert with_excluded.lines()[-1].split()[:4] == ["excluded", "1", "trajectory", "(25.0%),"]
    assert report.document()["counts"]["train"] == {"trajectories": 3, "frames": 9}
    assert report.document()["held_out"] == {"sensor": ["A"]}
    assert report.document()["notes"] == ["a note"]


@pytest.mark.parametrize(("thin", "more"), [(1, ""), (10, ""), (11, " and 1 more"), (15, " and 5 more")])
def test_ten_strata_with_holes_are_named(thin, more):
    """Strata without a trajectory in a part are named up to ten, and counted beyond."""
    full = Stratum({"sensor": "full"}, counts(train=(1, 1), val=(1, 1)))
    strata = (*(Stratum({"sensor": f"s{k}"}, counts(train=(1, 1))) for k in range(thin)), full)
    (note,) = _thin_strata(strata, ["train", "val"])
    names = "; ".join(f"sensor s{k}" for k in range(min(thin, 10)))
    assert note == f"val has no trajectory of: {names}{more} (of {thin + 1} strata)"


def test_a_stratum_outside_the_shares_has_no_hole():
    """What is wholly held out or excluded need not be in train; where all are full nothing is said."""
    unseen = Stratum({"sensor": "A"}, counts(test_unseen=(4, 4), excluded=(1, 1)))
    full = Stratum({"sensor": "B"}, counts(train=(1, 1), val=(1, 1), test=(2, 2)))
    assert _thin_strata((unseen, full), list(SHARES)) == []


@pytest.mark.parametrize(
    ("seeds", "hint"),
    [
        ([], "few for chance to fill every part; try another seed (--seed N --replace), or add data"),
        ([4], "the same command with --seed 4 --replace fills every part"),
        ([4, 7], "the same command with --seed 4 --replace fills every part (and so do 7)"),
        ([4, 7, 9], "the same command with --seed 4 --replace fills every part (and so do 7 and 9)"),
    ],
)
def test_empty_parts_are_named_with_a_way_out(seeds, hint, monkeypatch):
    """Val and test got nothing of three groups: other seeds are named where there are some."""
    monkeypatch.setattr("tactiledata.splits.report.filling_seeds", lambda sizes, options: seeds)
    table = dealt(*[("train", 1, "A", "x")] * 3, ("test_unseen", 1, "A", "x"))
    (note,) = _part_notes(table, NONE, count_parts(table), list(SHARES), True)
    assert note.startswith("val and test got no trajectory: 3 groups are few for chance")
    assert note.endswith(hint)
    (note,) = _part_notes(table, NONE, count_parts(table), list(SHARES), False)
    assert note.endswith("try another seed (--seed N --replace), or add data")


def test_no_seed_is_advised_where_parents_lie_elsewhere(monkeypatch):
    """Another seed would part derived trajectories from their parents; recorded ones are told one."""
    monkeypatch.setattr("tactiledata.splits.report.filling_seeds", lambda sizes, options: [4])
    table = dealt(*[("train", 1, "A", "x")] * 3)
    notes = notes_on(table, NONE, {}, count_parts(table), ())
    assert any("--seed 4" in note for note in notes)
    place = table.schema.get_field_index("root")
    parted = table.set_column(place, "root", pa.array([f"elsewhere {k}" for k in range(3)]))
    notes = notes_on(parted, NONE, {}, count_parts(parted), ())
    assert not any("--seed" in note for note in notes)
    assert any(note.endswith("stand apart from the trajectories that they derive from") for note in notes)


def test_fewer_groups_than_parts_cannot_fill_them():
    """Two groups for three parts: no seed helps; a part without frames is named apart."""
    table = dealt(("train", 1, "A", "x"), ("val", 0, "A", "x"))
    notes = _part_notes(table, NONE, count_parts(table), list(SHARES), True)
    assert notes == [
        "val has 1 trajectory and no frames: 1 group with frames cannot fill 3 parts; add data, or ask for fewer parts "
        "with --fractions",
        "test got no trajectory: 2 groups cannot fill 3 parts; add data, or ask for fewer parts with --fractions",
    ]
    whole = dealt(("train", 1, "A", "x"), ("val", 1, "A", "x"), ("test", 1, "A", "x"))
    thirds = SplitOptions.checked(hold_out="none", fractions=(0.34, 0.33, 0.33))
    assert _part_notes(whole, thirds, count_parts(whole), list(SHARES), True) == []
    # filled, but not as was asked: 0.8, 0.1, 0.1
    (astray,) = _part_notes(whole, NONE, count_parts(whole), list(SHARES), True)
    assert astray.startswith("the parts are drawn by chance, and 3 trajectories are few: train has 33% of them")


def test_a_part_without_frames_is_named_with_a_way_out(monkeypatch):
    """Seeds are sought that give each part a group with frames; nothing is proposed where no group has any."""
    sought = []
    monkeypatch.setattr("tactiledata.splits.report.filling_seeds", lambda sizes, options: sought.append(sizes) or [4])
    table = dealt(("train", 1, "A", "x"), ("train", 2, "A", "x"), ("val", 1, "A", "x"), ("test", 0, "A", "x"))
    (note,) = _part_notes(table, NONE, count_parts(table), list(SHARES), True)
    assert note == (
        "test has 1 trajectory and no frames: 3 groups with frames are few for chance to fill every part; "
        "the same command with --seed 4 --replace fills every part"
    )
    assert sought == [dict.fromkeys(sorted(table["group"].to_pylist()[:3]), 1)]
    bare = dealt(("train", 0, "A", "x"), ("val", 0, "A", "x"), ("test", 0, "A", "x"))
    notes = _part_notes(bare, NONE, count_parts(bare), list(SHARES), True)
    assert notes == [f"{part} has 1 trajectory and no frames" for part in SHARES]


def test_only_parts_that_were_asked_for_can_be_empty():
    """With a share of 0 for test nothing is said of it; all notes of a good split are none."""
    table = dealt(*[("train", 1, "A", "x")] * 3, *[("val", 1, "A", "x")] * 3)
    two = SplitOptions.checked(hold_out="none", fractions=(0.5, 0.5, 0.0))
    assert notes_on(table, two, {}, count_parts(table), ()) == []


def test_unnamed_units_orphans_and_silent_trajectories_are_counted():
    """Two without a sensor, one without an indenter, two parents that are not there, three without a frame."""
    rows = [
        {"sensor": "", "indenter": ""},
        {"sensor": ""},
        {"parent": "p"},
        {"parent": "p"},
        {"parent": "q"},
        {},
        {},
        {},
    ]
    table = assign(
        trajectories([{"source": k, **row} for k, row in enumerate(rows)]), NONE, {}, np.array([0, 0, 0, 1, 2, 1, 1, 1])
    )
    notes = "\n".join(notes_on(table, NONE, {}, count_parts(table), ()))
    assert "name no sensor: 2; nobody" in notes
    assert "name no indenter: 1; nobody" in notes
    assert "derive from 2 parent trajectories that this store does not hold" in notes
    assert "without a frame that the split takes (see the contact filter, --force): 3" in notes


def test_what_is_in_no_part_is_counted_by_its_kind():
    """Recorded ones and derived ones have a sentence each; none has none."""
    table = trajectories([{"source": 0}, {"source": 1}, {"source": 2, "parent": f"{0:016x}"}, {"source": 3}])
    split = assign(table, NONE, {})
    place = split.column_names.index("partition")
    out = split.set_column(place, "partition", pa.array([EXCLUDED, EXCLUDED, EXCLUDED, "train"]))
    recorded, derived = _excluded(out)
    assert recorded.startswith("in no part: 2 recorded trajectories")
    assert derived.startswith("in no part: 1 derived trajectory")
    assert _excluded(split.set_column(place, "partition", pa.array(["train"] * 4))) == []


def test_frames_that_a_filter_leaves_out_are_counted():
    """Of nine frames three are in contact, two without a force; without a filter nothing is said."""
    force = np.array([0.5, 1.0, 5.0, 13.0, 14.0, 20.0, np.nan, np.nan, 0.0])
    table = frames(trajectories([{}, {}, {}]), 3, contact_force=force)
    taken = taken_frames(table, (1.0, 13.0))
    assert check_force_filter(table, taken, (1.0, 13.0)) == [
        "3 of 9 frames are taken: contact force in 1..13 N, image whole",
        "2 frames have no contact force and are in no part; --force none takes them",
    ]
    assert check_force_filter(table, taken_frames(table, None), None) == []
    known = frames(trajectories([{}, {}, {}]), 3)
    assert len(check_force_filter(known, taken_frames(known, (1.0, 13.0)), (1.0, 13.0))) == 1


def test_the_reach_of_forces_is_that_of_usable_frames():
    """A broken frame's force does not count: 2 to 4 N; where only broken ones have forces, they are not known."""
    table = trajectories([{}])
    broken = int(FrameFlag.BROKEN)
    some = frames(table, 3, contact_force=np.array([2.0, 4.0, 9.0]), flags=np.array([0, 0, broken]))
    with pytest.raises(StoreError, match=r"has a contact force in 5\.\.13 N: forces reach from 2 to 4 N"):
        check_force_filter(some, taken_frames(some, (5.0, 13.0)), (5.0, 13.0))
    lone = frames(table, 3, contact_force=np.array([np.nan, np.nan, 9.0]), flags=np.array([0, 0, broken]))
    with pytest.raises(StoreError, match=r"in 5\.\.13 N: theirs are not known"):
        check_force_filter(lone, taken_frames(lone, (5.0, 13.0)), (5.0, 13.0))


def test_frames_point_into_the_table_of_trajectories():
    """Row 1 of two trajectories is there, row 2 is not; without a frame all counts are 0."""
    table = frames(trajectories([{}, {}]), 2)
    assert frames_per_trajectory(table, np.array([True, False, True, True]), 2).tolist() == [1, 2]
    assert frames_per_trajectory(table, np.zeros(4, bool), 2).tolist() == [0, 0]
    with pytest.raises(StoreError, match="trajectory row 1, and there are 1 trajectories"):
        frames_per_trajectory(table, np.ones(4, bool), 1)


def test_the_split_that_a_store_gives_is_suggested(tmp_path):
    """A split by sensor is suggested, of frames in contact or of all, or the report says why none can be."""
    table = trajectories(many(20))
    found = suggest_split(MemoryStore(tmp_path / "a b", table))
    assert found.command == f"tactiledata split '{tmp_path}/a b' --by trajectory,sensor"
    assert sum(count.frames for count in found.report.counts.values()) == 60
    without = frames(table, 3, contact_force=np.full(60, np.nan))
    found = suggest_split(MemoryStore(tmp_path, table, without))
    assert found.command.endswith("--by trajectory,sensor --force none")
    assert (found.report.options.force, found.reason) == (None, "")
    none = suggest_split(MemoryStore(tmp_path, trajectories(many(1))))
    assert (none.command, none.report) == ("", None)
    assert "the store has one trajectory" in none.reason
