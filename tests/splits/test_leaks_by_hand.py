"""Leaks in tables of a few rows: every pair of parts, how cases are shown, and what lies in no part."""

import numpy as np
import pyarrow as pa
import pytest
from split_cases import MemoryStore, frames, trajectories

from tactiledata.splits.assign import assign
from tactiledata.splits.audit import audit
from tactiledata.splits.leaks import (
    identical_payloads,
    leak,
    parted_frames,
    parted_touches,
    partition_codes,
    sensors_without_serial,
    shared_uids,
    unlike_drawn,
)
from tactiledata.splits.make import make_split
from tactiledata.splits.options import PARTITIONS, SplitOptions
from tactiledata.splits.twins import tells_a_moment

NONE = SplitOptions.checked(hold_out="none")
PLACES = [*PARTITIONS, None]


def codes(*parts):
    return partition_codes(np.array(parts, object))


@pytest.mark.parametrize(
    ("count", "message"),
    [(1, "what: a"), (3, "what: a; b; c"), (4, "what: a; b; c and 1 more"), (9, "what: a; b; c and 6 more")],
)
def test_three_cases_are_shown(count, message):
    """Up to three cases are named, the others counted; none is no finding."""
    (found,) = leak("code", "what", iter("abcdefghi"[:count]), count)
    assert (found.code, found.severity, found.message, found.count) == ("code", "damage", message, count)
    assert leak("code", "what", iter("abc"), 0) == []


def test_parts_have_numbers_and_no_part_has_minus_one():
    """train, val, test, test_unseen are 0 to 3; excluded and unknown ones are in no part."""
    assert codes(*PARTITIONS, "excluded", None).tolist() == [0, 1, 2, 3, -1, -1]


@pytest.mark.parametrize("own", PLACES)
@pytest.mark.parametrize("origin", PLACES)
def test_a_frame_and_its_parent_in_any_two_parts(own, origin):
    """A leak where both are in parts, and in different ones; the message names both frames and both parts."""
    table = trajectories([{}, {}, {}])
    parents = np.array([-1, -1, 0, -1, -1, 4])
    frame_table = frames(table, 2, parent_frame=parents)
    found = parted_frames(frame_table, np.ones(6, bool), codes(origin, own, "val"))
    is_leak = own is not None and origin is not None and own != origin
    assert [finding.count for finding in found] == [1] * is_leak
    if is_leak:
        assert found[0].message.endswith(f": frame 2 ({own}) from frame 0 ({origin})")


def test_frames_that_are_not_taken_or_have_lost_parents():
    """What a split leaves out is not judged; parents beyond the table, or outside any trajectory, are no leak."""
    table = trajectories([{}, {}])
    owner = np.array([0, -1, 1, 1])
    part = codes("train", "test")
    taken = np.array([True, True, True, True])
    found = parted_frames(frames(table, 2, parent_frame=np.array([-1, -1, 1, 0]), trajectory=owner), taken, part)
    assert [(finding.code, finding.count) for finding in found] == [("derived-frame-away-from-parent", 1)]
    assert (
        parted_frames(frames(table, 2, parent_frame=[-1, -1, 1, 0], trajectory=owner), taken & [1, 1, 1, 0], part) == []
    )
    for beyond, count in (([-1, -1, 4, 99], 2), ([-1, -1, 3, 4], 1)):
        (lost,) = parted_frames(frames(table, 2, parent_frame=beyond), taken, part)
        assert (lost.code, lost.severity, lost.count) == ("unknown-parent-frame", "warning", count)
        assert lost.message.startswith(f"{count} frames name a parent frame")


def test_a_trajectory_in_several_parts_is_named_with_all_of_them():
    """Twice in one part is none; in three parts they are named in the order of the alphabet."""
    table = pa.table({"uid": list("aabbbcc"), "partition": ["train", "train", "val", "train", "test", "test", "val"]})
    (found,) = shared_uids(table)
    assert found.count == 2
    assert found.message.endswith("parts: b in test and train and val; c in test and val")
    assert shared_uids(table.slice(0, 2)) == []


@pytest.mark.parametrize("one", PLACES)
@pytest.mark.parametrize("other", PLACES)
def test_two_touches_at_once_in_any_two_parts(one, other):
    """A leak where both are in parts, and in different ones; a derived copy of a touch is no touch."""
    rows = [{"start_ns": 0}, {"start_ns": 4_999}, {"start_ns": 9_999}, {"start_ns": 0, "parent": f"{0:016x}"}]
    found = parted_touches(trajectories(rows), codes(one, other, None, "val"))
    is_leak = one is not None and other is not None and one != other
    assert [finding.count for finding in found] == [1] * is_leak
    if is_leak:
        pair = sorted([("'t0'", one), ("'t1'", other)], key=lambda named: PARTITIONS.index(named[1]))
        assert found[0].message.endswith(" and ".join(f"{name} ({part})" for name, part in pair))


@pytest.mark.parametrize("one", PLACES)
@pytest.mark.parametrize("other", PLACES)
def test_equal_bytes_in_any_two_parts(one, other):
    """A leak where both are in parts, and in different ones."""
    table = trajectories([{}, {}, {}])
    length, crc = np.array([9, 5, 5, 7, 0, 0]), np.array([1, 2, 2, 2, 2, 2])
    found = identical_payloads(frames(table, 2, length=length, crc32c=crc), np.ones(6, bool), codes(one, other, "val"))
    is_leak = one is not None and other is not None and one != other
    assert [finding.count for finding in found] == [1] * is_leak
    if is_leak:
        assert found[0].message.endswith(f"frame 1 ({one}) and frame 2 ({other})")


def test_images_of_one_byte_and_large_ones_are_compared():
    """A length of 1 counts, one of 0 is no length; of more than four equal images four are named."""
    table = trajectories([{}, {}])
    n = np.ones(6, int)
    (found,) = identical_payloads(frames(table, 3, length=n, crc32c=n), np.ones(6, bool), codes("train", "test"))
    named = "frame 0 (train) and frame 1 (train) and frame 2 (train) and frame 3 (test)"
    assert (found.count, found.message.rpartition(": ")[2]) == (1, named)
    assert identical_payloads(frames(table, 3, length=0 * n, crc32c=n), np.ones(6, bool), codes("train", "test")) == []
    large = np.array([2**31 - 1, 2**31 - 2, 1, 2**31 - 1, 2, 3])
    crc = np.array([2**32 - 1, 2**32 - 1, 5, 2**32 - 1, 6, 7])
    (found,) = identical_payloads(frames(table, 3, length=large, crc32c=crc), np.ones(6, bool), codes("train", "test"))
    assert found.message.endswith("frame 0 (train) and frame 3 (test)")


@pytest.mark.parametrize(
    ("lengths", "crcs"),
    [
        ((1, 1), (0, 2**31)),  # the upper bit of a CRC is no bit of a length
        ((2, 3), (2**31, 2**31)),
        ((2, 3), (2**31, 0)),
        ((2**31 - 1, 2**30 - 1), (5, 5)),  # the upper bit of a length is not lost
    ],
)
def test_bits_of_length_and_crc_are_not_mixed(lengths, crcs):
    """Images that differ in length or in CRC are other images, whatever bits the two numbers have."""
    table = trajectories([{}, {}])
    columns = {"length": np.array(lengths), "crc32c": np.array(crcs)}
    assert identical_payloads(frames(table, 1, **columns), np.ones(2, bool), codes("train", "test")) == []


def test_what_stands_elsewhere_than_drawn():
    """Moved trajectories are named with both parts; units that a table names otherwise are counted by kind."""
    table = trajectories([{"source": k} for k in range(6)])
    drawn = assign(table, NONE, {})
    says = np.asarray(drawn["partition"].to_pylist(), object)
    assert unlike_drawn(table, drawn, says, NONE, {}) == []
    other = says.copy()
    other[2], other[4] = "test_unseen", None
    (found,) = unlike_drawn(table, drawn, other, NONE, {})
    assert (found.code, found.count) == ("not-as-drawn", 1)
    assert found.message.endswith(f"{2:016x} in test_unseen, drawn for {says[2]}")
    renamed = trajectories([{"source": k, "sensor": "B" if k < 2 else "A", "indenter": "x"} for k in range(6)])
    found = unlike_drawn(renamed, drawn, says, NONE, {})
    assert [(finding.code, finding.count) for finding in found] == [("unit-renamed", 2), ("unit-renamed", 6)]
    both = [f"{row:016x} of sensor 'B' in the store, 'A' in the table" for row in (0, 1)]
    assert found[0].message == f"the split's table names another sensor than the store: {'; '.join(both)}"
    # six trajectories: three are named, three are counted
    assert found[1].message.count("in the store") == 3
    assert found[1].message.endswith(" and 3 more")


def test_a_trajectory_that_the_table_lacks_is_not_renamed():
    """Only trajectories that stand in the split's table can be named otherwise there."""
    table = trajectories([{"source": k} for k in range(4)])
    drawn = assign(table, NONE, {})
    says = np.asarray(drawn["partition"].to_pylist(), object)
    renamed = trajectories([{"source": k, "sensor": "B"} for k in range(4)])
    (found,) = [
        finding for finding in unlike_drawn(renamed, drawn.slice(1), says, NONE, {}) if finding.code == "unit-renamed"
    ]
    assert (found.count, f"{0:016x}" in found.message) == (3, False)


def test_nine_september_2001_divides_clocks():
    """10^18 ns after 1970 tell a moment, one nanosecond less does not; without a sensor's name nothing does."""
    start = np.array([10**18 - 1, 10**18, 10**18 + 1, 10**18], np.int64)
    named = np.array([True, True, True, False])
    assert tells_a_moment(start, named).tolist() == [False, True, True, False]


def test_sensors_without_a_serial_are_told():
    """An audit says that nameless sensors may be one camera; a lone sensor and named ones leave nothing to be said."""
    nameless = [{"sensor": f"unknown-{k:08x}"} for k in range(4)]
    (found,) = sensors_without_serial(trajectories(nameless))
    assert (found.code, found.severity, found.count) == ("sensor-without-serial", "warning", 4)
    assert found.message.startswith("4 sensors without a serial (unknown-00000000, unknown-00000001, ")
    (one,) = sensors_without_serial(trajectories([nameless[0], {"sensor": "A"}]))
    assert one.message.startswith("1 sensor without a serial (unknown-00000000) may be one of the other cameras")
    assert sensors_without_serial(trajectories(nameless[:1] * 3)) == []
    assert sensors_without_serial(trajectories([{"sensor": "A"}, {"sensor": "B"}])) == []


def test_an_audit_asks_for_serials(tmp_path):
    """The audit of a drawn split holds the warning about nameless sensors, and calls it no leak."""
    store = MemoryStore(tmp_path, trajectories([{"sensor": f"unknown-{k % 3:08x}"} for k in range(30)]))
    make_split(store)
    report = audit(store, images=False)
    assert "sensor-without-serial" in {finding.code for finding in report.findings}
    assert not report.leaks
