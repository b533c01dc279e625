"""Stray sizes among the frames of a take: which are flagged, and the words that name them."""

import numpy as np

from tactiledata.contract.take import FrameFlag
from tactiledata.ingest.checks.image_sizes import mark_strays, size_counts
from tests.ingest.made_takes import frames

STRAY = FrameFlag.STRAY_SIZE


def marked(table, names=("t0", "t1")):
    changed, findings = mark_strays(table, list(names))
    assert changed.schema == table.schema
    return changed["flags"].to_pylist(), [(one.code, one.severity, one.count, one.message) for one in findings]


def test_usable_images_are_counted_by_sensor_and_size():
    """Height before width; images that nothing learns from do not count, frames outside trajectories do."""
    table = frames(
        5, sensor=["D1", "D1", "D2", "D1", "D2"], height=[8, 8, 5, 9, 5], width=6,
        flags=[0, FrameFlag.OUTSIDE, 0, 0, FrameFlag.BROKEN],
    )  # fmt: skip
    assert size_counts(table) == {"D1": {(8, 6): 2, (9, 6): 1}, "D2": {(5, 6): 1}}


def test_a_stray_is_flagged_by_both_of_its_sides():
    """An image that differs in height, or in width, or in both is another size; other flags stay."""
    count = 40
    height, width, flags = np.full(count, 8), np.full(count, 6), np.zeros(count, int)
    height[3], width[4], flags[4] = 9, 7, FrameFlag.GAP
    height[5], flags[5] = 9, FrameFlag.MISSING
    found, said = marked(frames(count, height=height, width=width, flags=flags))
    assert [row for row, flag in enumerate(found) if flag & STRAY] == [3, 4]
    assert found[4] == STRAY | FrameFlag.GAP
    assert [one[:3] for one in said] == [("image-stray-size", "warning", 1)] * 2
    assert said[0][3].startswith("1 of 39 images is 8 x 7 (rows x columns), of sensor 'D1'; 37 are 8 x 6: frame 4 of")
    assert said[1][3].startswith("1 of 39 images is 9 x 6")


def test_only_the_images_of_the_sensor_are_strays():
    """What is usual for one sensor may be a stray of another; with one size there is nothing to say."""
    sensor = ["D1"] * 10 + ["D2"] * 10
    height = [8] * 9 + [9] + [9] * 10
    found, said = marked(frames(20, sensor=sensor, height=height))
    assert np.flatnonzero(found).tolist() == [9]
    [(code, _, count, text)] = said
    assert (code, count) == ("image-stray-size", 1)
    assert "the other 9 are 8 x 6" in text
    assert marked(frames(3)) == ([0, 0, 0], [])


def test_strays_are_named_by_trajectory_and_number():
    """Three by place and time, then how many more; a frame outside of trajectories has no number."""
    height = np.full(50, 8)
    height[[22, 23, 49, 48]] = 9
    trajectory = np.where(np.arange(50) < 20, 0, np.where(np.arange(50) < 48, 1, -1))
    found, [(_, _, count, text)] = marked(frames(50, height=height, trajectory=trajectory))
    assert np.flatnonzero(found).tolist() == [22, 23, 48, 49]
    assert count == 4
    places = text.partition(": ")[2].partition(".")[0]
    assert places == (
        "frame 2 of trajectory 't1' (t_ns 220), frame 3 of trajectory 't1' (t_ns 230), "
        "a frame outside trajectories (t_ns 480) and 1 more"
    )
    height[49] = 8
    assert "more" not in marked(frames(50, height=height, trajectory=trajectory))[1][0][3].partition(".")[0]


def test_several_sizes_that_are_no_strays_are_said():
    """Three with their numbers, the most frequent first, and how many differ from the usual one; none is flagged."""
    height = [5] * 4 + [6] * 10 + [7] * 3 + [8] * 3
    found, [(code, severity, count, text)] = marked(frames(20, height=height))
    assert not any(found)
    assert (code, severity, count) == ("image-sizes-mixed", "warning", 10)
    assert "(rows x columns): 10 of 6 x 6, 4 of 5 x 6, 3 of 7 x 6. A dataset" in text
    assert [one[0] for one in marked(frames(20, height=[5] * 12 + [6] * 6 + [7] * 2))[1]] == [
        "image-stray-size",
        "image-sizes-mixed",
    ]
