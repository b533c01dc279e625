"""When the tool's weight is known, by the poses around a moment, just inside and just outside of each limit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.gravity import STANDARD_GRAVITY, tool_weight, without_pose
from tactiledata.units import SIGNAL_COLUMNS, signal_units

START = 1_700_000_000_000_000_000
MS = 1_000_000
SAME = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
COLUMNS = SIGNAL_COLUMNS["tcp"]


def tcp(times_ms, x=None, turn=None):
    """Poses at some moments: place along x (m) and turn about x (rad), by custom moving on all the time."""
    count = len(times_ms)
    t_ns = START + np.rint(np.asarray(times_ms) * MS).astype(np.int64)
    values = np.zeros((count, 7))
    values[:, 1:3] = [0.1, 0.3]
    values[:, 0] = np.arange(count) if x is None else x
    values[:, 3:] = Rotation.from_rotvec(np.outer(np.zeros(count) if turn is None else turn, [1, 0, 0])).as_quat()
    return StoredSignal(t_ns, values, COLUMNS, signal_units(COLUMNS), "base", Stamps(t_ns))


def lost(poses, times_ms):
    return without_pose(poses, START + np.rint(np.asarray(times_ms) * MS).astype(np.int64)).tolist()


def test_standard_gravity():
    """Standard gravity is the number of the brochure of the SI."""
    assert STANDARD_GRAVITY == 9.80665


@pytest.mark.parametrize(("gap", "is_lost"), [(500, False), (500 + 1e-6, True)])
def test_between_poses_half_a_second_apart_the_weight_is_known(gap, is_lost):
    """A nanosecond farther apart it is not; at the poses themselves it always is."""
    poses = tcp([0, 10, 20, 20 + gap, 30 + gap])
    assert lost(poses, [5, 10, 20, 20.5, 200, 19 + gap, 20 + gap, 25 + gap]) == [
        False, False, False, is_lost, is_lost, is_lost, False, False,
    ]  # fmt: skip


@pytest.mark.parametrize(("gap", "is_lost"), [(900, False), (900 + 1e-6, True)])
def test_of_slow_poses_three_periods_may_lie_between(gap, is_lost):
    """At 300 ms from pose to pose, 900 ms are no gap."""
    assert lost(tcp([0, 300, 600, 900, 900 + gap]), [100, 1000]) == [False, is_lost]


def test_the_first_and_the_last_gap_count_from_their_first_nanosecond():
    """The gaps between the first two poses and between the last two count from their first nanosecond."""
    inside = [1e-6, 500, 900 - 1e-6]
    assert lost(tcp([0, 900, 910, 920, 930]), [0, *inside, 900]) == [False, True, True, True, False]
    assert lost(tcp([-30, -20, -10, 0, 900]), [0, *inside, 900]) == [False, True, True, True, False]


def test_the_first_and_the_last_pose_are_held_for_a_tenth_of_a_second():
    """The outer poses are held for a tenth of a second on either side, slow ones for three periods."""
    assert lost(tcp([0, 10, 20]), [-100 - 1e-6, -100, -1, 21, 120, 120 + 1e-6]) == [True, *[False] * 4, True]
    assert lost(tcp([0, 50, 100]), [-150 - 1e-6, -150, 250, 250 + 1e-6]) == [True, False, False, True]


def test_one_pose_is_held_and_none_holds_nothing():
    """A single pose is known for a tenth of a second around it; where all are broken nothing is known."""
    assert lost(tcp([0]), [-101, -100, 0, 100, 101]) == [True, False, False, False, True]
    broken = tcp([0, 10])
    broken.values[:, 3:] = 0
    assert lost(broken, [0, 5]) == [True, True]


def test_a_broken_pose_leaves_a_gap():
    """Between sound poses 600 ms apart a broken one does not count, nor one that is not known."""
    for change in (slice(3, 7), slice(0, 1)):
        poses = tcp([0, 10, 20, 300, 620, 630])
        poses.values[3, change] = 0 if change.start else np.nan
        assert lost(poses, [15, 300, 610, 625]) == [False, True, True, False]


@pytest.mark.parametrize(("along", "is_moved"), [(0.99e-4, False), (1.01e-4, True), (-1.01e-4, True)])
def test_an_arm_that_is_a_tenth_of_a_millimetre_away_moved(along, is_moved):
    """Below that it stood over the gap, and its weight is known there."""
    assert lost(tcp([0, 10, 20, 1000], [0.2, 0.3, 0.4, 0.4 + along]), [500]) == [is_moved]


@pytest.mark.parametrize(("turn", "is_moved"), [(1.98e-3, False), (2.02e-3, True), (-2.02e-3, True)])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_arm_that_turned_by_two_milliradians_moved(turn, is_moved, sign):
    """Less is none; q and -q are one rotation, and a quaternion may be a little longer than 1."""
    poses = tcp([0, 10, 20, 1000], np.zeros(4), [0.7, 0.7, 0.7, 0.7 + turn])
    poses.values[2, 3:] *= 1.05
    poses.values[3, 3:] *= sign * 0.97
    assert lost(poses, [500]) == [is_moved]


def described(**robot):
    return LogDescription({"robot": {"tcp_from_ft": SAME, "tool": {"mass": 2.0}, **robot}}, "test")


def test_without_mass_frame_or_poses_no_weight_is_known():
    """Each of them is needed, and poses that are all broken are none."""
    poses, moments = tcp([0, 10]), START + np.arange(2)
    assert tool_weight(described(), poses, moments) is not None
    assert tool_weight(LogDescription({"robot": {"tcp_from_ft": SAME}}), poses, moments) is None
    assert tool_weight(LogDescription({"robot": {"tool": {"mass": 2.0}}}), poses, moments) is None
    assert tool_weight(described(), None, moments) is None
    assert tool_weight(described(), tcp([]), moments) is None
    poses.values[:, 3:] = 0
    assert tool_weight(described(), poses, moments) is None


def test_a_weight_without_a_centre_hangs_at_the_tcp():
    """Of an upright arm it has no torque there; the arm turned by a right angle about x feels it along -y."""
    weight = tool_weight(described(), tcp([0, 10], turn=[0, np.pi / 2]), START + np.array([0, 10 * MS]))
    assert weight == pytest.approx(np.array([[0, 0, -19.6133, 0, 0, 0], [0, -19.6133, 0, 0, 0, 0]]), abs=1e-9)


def test_poses_are_held_before_the_first_and_after_the_last_sound_one():
    """Broken ones at the ends do not count: the weight is that of the nearest sound pose."""
    poses = tcp([0, 10, 20, 30, 40], turn=[0, 0, 0, np.pi / 2, 0])
    poses.values[[0, 4], 3:] = 0
    weight = tool_weight(described(), poses, START + np.array([-50, 5, 35, 90]) * MS)
    assert weight[:, 2] == pytest.approx([-19.6133, -19.6133, 0, 0], abs=1e-9)
    assert weight[:, 1] == pytest.approx([0, 0, -19.6133, -19.6133], abs=1e-9)


def test_the_lever_is_about_the_origin_of_the_ft_frame():
    """A sensor 0.1 m above the tcp, turned about z, has force and torque in its own frame."""
    turned = {"xyz": [0.0, 0.0, -0.1], "xyzw": [0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]}
    robot = {"tcp_from_ft": turned, "tool": {"mass": 2.0, "centre_of_gravity": [0.2, 0.0, 0.0]}}
    weight = tool_weight(described(**robot), tcp([0, 10], turn=[0, np.pi / 2]), START + np.array([0, 10 * MS]))
    # the lever, 0.2 m along x and 0.1 m along z of the tcp, is -0.2 m along y and 0.1 m along z of the sensor
    assert weight[0] == pytest.approx([0, 0, -19.6133, 3.92266, 0, 0], abs=1e-9)
    assert weight[1] == pytest.approx([-19.6133, 0, 0, 0, -1.96133, -3.92266], abs=1e-9)


def test_an_arm_that_stands_in_any_pose_stood():
    """Rounding makes no turn of a pose that is twice the same, nor a number that is none."""
    turns = Rotation.random(200, random_state=1).as_quat()
    poses = tcp(np.arange(400) // 2 * 2000 + np.arange(400) % 2 * 1000, np.zeros(400))
    poses.values[:, 3:] = np.repeat(turns, 2, axis=0)
    with np.errstate(invalid="raise"):
        assert not any(lost(poses, np.arange(200) * 2000 + 500))
