"""The frames of a recording: their times, sensors, order and flags, column by column."""

import numpy as np
import pyarrow as pa
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source
from tactiledata.contract.take import FRAME_SCHEMA, FrameFlag
from tactiledata.ingest.trajectories.frames import (
    capture_times,
    frame_flags,
    frame_order,
    frames_table,
    rows_by_camera,
    times_by_camera,
)

START = 1_700_000_000_000_000_000
SECOND = 10**9


def images(cameras, log=None, publish=-1, header=-1, sensors=""):
    """A spool's columns of images a second apart."""
    count = len(cameras)
    log = START + np.arange(count) * SECOND if log is None else log

    def column(value):
        return value if np.ndim(value) else [value] * count

    return pa.table({
        "camera": cameras, "encoding": ["png", "raw", "missing", "jpeg", "png"][:count], "sensor": column(sensors),
        "trajectory": [""] * count, "log_ns": column(log), "publish_ns": column(publish), "header_ns": column(header),
        "height": range(10, 10 + count), "width": range(20, 20 + count), "offset": range(30, 30 + count),
        "length": range(40, 40 + count), "crc32c": range(50, 50 + count),
    })  # fmt: skip


def recording(clock="auto", **document):
    return Recording(Source("p", "k", "folder", ()), LogDescription(document), host_clock=clock)


CAMERAS = ["right", "left", "right", "left", "right"]


def test_each_camera_has_its_own_clock():
    """One has header stamps of another clock, the other none; rows stay in the order of the recording."""
    header = np.array([1, -1, 2 * SECOND + 1, -1, 4 * SECOND + 1])
    captured = capture_times(recording(), images(CAMERAS, header=header))
    assert captured.t_ns.tolist() == (START + np.arange(5) * SECOND).tolist()
    assert captured.clocks == {
        "left": {"clock": "log", "shift_ns": 0},
        "right": {"clock": "header+shift", "shift_ns": START - 1},
    }
    assert [(one.code, one.stream) for one in captured.findings] == [("clock-shifted", "right")]
    assert {name: rows.tolist() for name, rows in rows_by_camera(captured).items()} == {
        "left": [1, 3],
        "right": [0, 2, 4],
    }
    assert {name: (times - START).tolist() for name, times in times_by_camera(captured).items()} == {
        "left": [SECOND, 3 * SECOND],
        "right": [0, 2 * SECOND, 4 * SECOND],
    }


def test_stamps_that_no_image_has_are_none():
    """-1 throughout is no stamp, also of the log; a single stamp that is there counts, and 0 is one that is not set."""
    assert capture_times(recording("publish"), images(["a"] * 3, publish=7)).t_ns.tolist() == [7] * 3
    assert capture_times(recording("publish"), images(["a"] * 3)).t_ns[0] == START
    assert capture_times(recording("log"), images(["a"] * 3, log=-1)).t_ns.tolist() == [0] * 3
    one = capture_times(recording(), images(["a"] * 3, header=[-1, START, -1]))
    assert "2 of 3 header stamps are not set" in one.findings[0].message
    zero = capture_times(recording(), images(["a"] * 3, header=0))
    assert "3 of 3 header stamps are not set" in zero.findings[0].message


def test_the_offset_of_frames_is_added_and_their_order_is_said():
    """A stated offset is added to images with one stamp, and two that change places are a finding."""
    log = START + np.array([0, 2, 1]) * SECOND
    captured = capture_times(recording(clocks={"frames": {"offset_ns": 5, "known": True}}), images(["a"] * 3, log=log))
    assert (captured.t_ns - log).tolist() == [5] * 3
    assert captured.clocks == {"a": {"clock": "log", "shift_ns": 5}}
    assert [one.code for one in captured.findings] == ["time-order"]


@pytest.mark.parametrize(
    ("stated", "sensors"),
    [(["D1"], ["D1", "D9", "D1"]), (["D1", "D2"], ["", "D9", ""]), ([], ["", "D9", ""])],
)
def test_the_only_stated_sensor_took_the_images_of_nobody(stated, sensors):
    """Where two are stated, or none, nobody knows."""
    described = recording(sensors={name: {} for name in stated})
    assert capture_times(described, images(["a"] * 3, sensors=["", "D9", ""])).sensors == sensors


def test_frames_are_sorted_by_trajectory_time_and_camera():
    """Those outside any trajectory come last."""
    log = START + np.array([3, 1, 1, 0, 2]) * SECOND
    captured = capture_times(recording("log"), images(CAMERAS, log=log))
    assert frame_order(captured, np.array([0, 0, 0, -1, -1], np.int32)).tolist() == [1, 2, 0, 3, 4]
    assert frame_order(captured, np.array([1, 0, 1, -1, 0], np.int32)).tolist() == [1, 4, 2, 0, 3]


def test_a_table_of_frames_by_hand():
    """Every column in the store's order, with the schema's types, whatever the order of the recording was."""
    captured = capture_times(recording("log"), images(CAMERAS, publish=7))
    order = np.array([4, 0, 2])
    table = frames_table(
        captured, order, np.array([0, 1, -1], np.int32), ["D2", "D1", "D2"],
        np.array([1, 2, np.nan], np.float32), np.array([0, 4, 9], np.uint32),
    )  # fmt: skip
    assert table.schema == FRAME_SCHEMA
    assert table.drop_columns(["contact_force"]).to_pydict() == {
        "trajectory": [0, 1, -1], "source": [0] * 3, "camera": ["right"] * 3, "sensor": ["D2", "D1", "D2"],
        "t_ns": [START + 4 * SECOND, START, START + 2 * SECOND],
        "log_ns": [START + 4 * SECOND, START, START + 2 * SECOND], "publish_ns": [7] * 3, "header_ns": [-1] * 3,
        "encoding": ["png", "png", "missing"], "height": [14, 10, 12], "width": [24, 20, 22],
        "offset": [34, 30, 32], "length": [44, 40, 42], "crc32c": [54, 50, 52], "flags": [0, 4, 9],
        "parent_frame": [-1] * 3,
    }  # fmt: skip
    np.testing.assert_array_equal(table["contact_force"].to_numpy(), np.array([1, 2, np.nan], np.float32))
    assert table["sensor"].chunk(0).dictionary.to_pylist() == ["D1", "D2"]


def test_flags_by_hand():
    """Flags mark missing images, frames outside trajectories, and values over a long gap or without samples."""
    encodings = ["png", "missing", "png", "png", "png"]
    rows = np.array([0, 1, -1, 1, -1], np.int32)
    gaps = {"wrench": np.array([100, 0, 101, 100, -1]), "tcp": np.array([0, 0, 0, -1, 0])}
    found = frame_flags(encodings, rows, gaps, 100)
    assert found.dtype == np.uint32
    gap, outside = FrameFlag.GAP, FrameFlag.OUTSIDE
    assert found.tolist() == [0, FrameFlag.MISSING, outside | gap, gap, outside | gap]
    assert frame_flags(encodings, rows, {}, 100).tolist() == [0, FrameFlag.MISSING, outside, 0, outside]
    assert frame_flags([], rows[:0], {}, 100).tolist() == []
