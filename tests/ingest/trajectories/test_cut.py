"""Which frames and samples belong to which trajectory, in times of a few nanoseconds."""

import json

import numpy as np
import pytest

from tactiledata.contract.records import Finding, Trajectory
from tactiledata.contract.take import TRAJECTORY_SCHEMA
from tactiledata.ingest.trajectories.cut import (
    assign_frames,
    check_trajectories,
    lost_spans_hit,
    trajectory_table,
    trajectory_uid,
    within,
)
from tests.ingest.made_takes import signal


def checked(*rows):
    found = check_trajectories(tuple(Trajectory(*row) for row in rows))
    return [one.name for one in found.trajectories], [
        (one.code, one.severity, one.trajectory, one.start_ns, one.end_ns) for one in found.findings
    ]


def test_trajectories_are_sorted_by_start_end_and_name():
    """What begins together is sorted by its end, then by name."""
    names, said = checked(("c", 5, 9, "D1"), ("b", 0, 5, "D1"), ("z", 5, 8, "D2"), ("a", 5, 9, "D3"))
    assert names == ["b", "z", "a", "c"]
    assert said == []


@pytest.mark.parametrize(("end", "kept"), [(4, []), (5, []), (6, ["t"])])
def test_what_ends_at_or_before_its_start_is_left_out(end, kept):
    """A trajectory that ends at or before its start is left out and said; what comes after it stays."""
    names, said = checked(("t", 5, end), ("later", 10, 20))
    assert names == [*kept, "later"]
    assert said == ([] if kept else [("trajectory-reversed", "damage", "t", None, None)])


def test_repeated_names_are_numbered():
    """The first keeps its name, the second is ~2, the third ~3."""
    names, said = checked(("t", 0, 1), ("t", 1, 2), ("u", 2, 3), ("t", 3, 4))
    assert names == ["t", "t~2", "u", "t~3"]
    assert said == [
        ("trajectory-name-repeated", "warning", "t~2", None, None),
        ("trajectory-name-repeated", "warning", "t~3", None, None),
    ]


def test_overlaps_of_one_sensor_are_damage():
    """An overlap of a nanosecond is damage; two sensors may overlap, and an unknown one may be the same."""
    assert checked(("a", 0, 10), ("b", 10, 20))[1] == []
    assert checked(("a", 0, 10), ("b", 9, 20))[1] == [("trajectory-overlap", "damage", "b", 9, 10)]
    assert checked(("a", 0, 30), ("b", 9, 20))[1] == [("trajectory-overlap", "damage", "b", 9, 20)]
    assert checked(("a", 0, 10, "D1"), ("b", 9, 20, "D2"))[1] == []
    for one, other in (("D1", "D1"), ("D1", ""), ("", "D1")):
        assert len(checked(("a", 0, 10, one), ("b", 9, 20, other))[1]) == 1
    # only the one before counts
    assert len(checked(("a", 0, 30, "D1"), ("b", 5, 10, "D2"), ("c", 20, 40, "D2"))[1]) == 0


TWO = (Trajectory("a", 0, 10, "D1"), Trajectory("b", 5, 20), Trajectory("c", 20, 30, "D2"))


def assigned(t_ns, sensors="D1", named=None):
    count = len(t_ns)
    return assign_frames(
        TWO, np.array(t_ns), [sensors] * count if isinstance(sensors, str) else sensors, named or [""] * count
    ).tolist()


def test_frames_belong_to_the_first_interval_that_holds_them():
    """Half-open, of their own sensor or where one of the two is not known."""
    assert assigned([-1, 0, 9, 10, 19, 20, 30]) == [-1, 0, 0, 1, 1, -1, -1]
    assert assigned([4, 5, 20, 29, 30], "D2") == [-1, 1, 2, 2, -1]
    assert assigned([0, 9, 20], "") == [0, 0, 2]
    assert assigned([0, 0], ["D3", ""]) == [-1, 0]
    assert assigned([20, 20], "A") == [-1, -1]


def test_a_frame_that_names_its_trajectory_belongs_there():
    """Whatever its time and sensor; a name that is not known does not count."""
    assert assigned([0, 99, 0], "D1", ["c", "a", "nobody"]) == [2, 0, 0]
    assert assigned([0]) == [0]


def test_a_frame_that_names_a_parted_trajectory_belongs_to_the_part_of_its_sensor():
    """Whatever its time; a trajectory of just that name comes first, and a part of another sensor is not its own."""
    parts = (Trajectory("a-D1", 0, 10, "D1"), Trajectory("a-D2", 0, 10, "D2"), Trajectory("b", 20, 30, "D2"),
             Trajectory("b-D2", 40, 50, "D2"))  # fmt: skip
    rows = assign_frames(parts, np.full(5, 99), ["D1", "D2", "D3", "D2", "D2"], ["a", "a", "a", "b", ""])
    assert rows.tolist() == [0, 1, -1, 2, -1]


def test_a_frame_lies_within_its_own_trajectory():
    """Half-open; a frame of none lies within none, whatever the last one holds."""
    rows = np.array([0, 0, 0, 1, 1, -1, 2, 0], np.int32)
    t_ns = np.array([0, 9, 10, 4, 5, 25, 29, 15])
    assert within(TWO, rows, t_ns).tolist() == [True, True, False, False, True, False, True, False]
    assert within((), np.array([-1], np.int32), np.array([5])).tolist() == [False]


def test_a_table_of_trajectories_by_hand():
    """Rows of frames and samples, the largest force over the samples, and what else is known of each."""
    values = np.zeros((6, 6))
    values[:, 0], values[:, 1], values[:, 3] = [0, 3, 0, 0, 6, 0], [0, 4, 0, 0, 8, 0], 99
    values[2] = np.nan
    signals = {
        "contact_wrench": signal("contact_wrench", [0, 5, 9, 10, 19, 20], values),
        "tcp": signal("tcp", [4, 5, 10], np.zeros((3, 7))),
    }
    trajectories = (*TWO[:2], Trajectory("c", 30, 40, "D2", "ball", {"b": 1, "a": "x"}))
    frame_rows = np.array([0, 0, 1, 2, -1, -1], np.int32)
    table = trajectory_table(trajectories, "ab", "log", frame_rows, np.full(6, 50, np.float32), signals)
    assert table.schema == TRAJECTORY_SCHEMA
    rows = table.to_pylist()
    assert [(row["frame_start"], row["frame_stop"]) for row in rows] == [(0, 2), (2, 3), (3, 4)]
    assert [json.loads(row["signal_rows"]) for row in rows] == [
        {"contact_wrench": [0, 3], "tcp": [0, 2]},
        {"contact_wrench": [1, 5], "tcp": [1, 3]},
        {"contact_wrench": [6, 6], "tcp": [3, 3]},
    ]
    assert [row["peak_force"] for row in rows[:2]] == [5, 10]
    assert np.isnan(rows[2]["peak_force"])
    assert rows[2] == rows[2] | {
        "uid": trajectory_uid("ab", "c"), "trajectory": "c", "source": 0, "sensor": "D2", "indenter": "ball",
        "start_ns": 30, "end_ns": 40, "segmented": "log", "parent": "", "extra": '{"a": "x", "b": 1}',
    }  # fmt: skip


def test_the_largest_force_without_a_wrench_is_that_of_the_frames():
    """The largest force is that of the trajectory's own frames, those without a force left out."""
    force = np.array([1, 7, np.nan, 3, 9], np.float32)
    table = trajectory_table(TWO, "ab", "log", np.array([0, 0, 1, 1, -1], np.int32), force, {})
    assert table["peak_force"].to_pylist()[:2] == [7, 3]
    assert np.isnan(table["peak_force"].to_pylist()[2])


def test_uids_are_sixteen_digits_of_source_and_name():
    """The first of the SHA-256 of ``ab/c``; other sources and other names have other ones."""
    assert trajectory_uid("ab", "c") == "fcb6b81f98ac643d"
    assert len({trajectory_uid("ab", "c"), trajectory_uid("ab", "d"), trajectory_uid("ac", "c")}) == 3


def damage(start, end, severity="damage", trajectory=""):
    return Finding("lost", severity, "lost", trajectory=trajectory, start_ns=start, end_ns=end)


@pytest.mark.parametrize(
    ("finding", "hit"),
    [
        (damage(9, 12), ["a", "b"]),
        (damage(10, 12), ["b"]),
        (damage(-5, -1), []),
        (damage(-5, 0), ["a"]),
        (damage(20, 20), ["c"]),
        (damage(30, 40), []),
        (damage(0, 50, "warning"), []),
        (damage(0, 50, trajectory="a"), []),
        (damage(None, 50), []),
        (damage(0, None), []),
    ],
)
def test_a_lost_span_is_held_against_every_trajectory(finding, hit):
    """Damage with both its ends known, that is about no trajectory itself, names those that it overlaps."""
    found = lost_spans_hit(TWO, [damage(None, None), finding])
    assert [one.trajectory for one in found] == hit
    assert all((one.code, one.severity) == ("trajectory-incomplete", "damage") for one in found)
    spans = {one.name: (one.start_ns, one.end_ns) for one in TWO}
    assert all((one.start_ns, one.end_ns) == spans[one.trajectory] for one in found)
