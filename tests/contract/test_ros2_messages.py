"""Messages of ROS 2 read back by rosbags: their stamps, and the numbers of many messages made at once."""

import numpy as np
from rosbags.typesys import Stores, get_typestore

from tactiledata.contract.ros2_messages import repeated, wrench

TYPES = get_typestore(Stores.ROS2_HUMBLE)
KIND = "geometry_msgs/msg/WrenchStamped"
STAMP = 1_700_000_003_000_000_042
"""ns: seconds and nanoseconds whose digits differ."""


def parts(content):
    """Seconds, nanoseconds, and the six numbers of a message."""
    message = TYPES.deserialize_cdr(content, KIND)
    force, torque, stamp = message.wrench.force, message.wrench.torque, message.header.stamp
    return stamp.sec, stamp.nanosec, (force.x, force.y, force.z, torque.x, torque.y, torque.z)


def test_a_stamp_is_seconds_and_the_nanoseconds_beyond_them():
    """1,700,000,003 s and 42 ns: neither is the other, and nothing is lost."""
    values = np.array([1.0, -2.0, 3.5, 0.25, -0.5, 0.125])
    assert parts(wrench(STAMP, "tool", values)) == (1_700_000_003, 42, tuple(values))


def test_messages_made_at_once_are_those_made_one_by_one():
    """Every stamp and every number stands at its own place, whichever message is asked for."""
    chance = np.random.default_rng(0)
    stamps = STAMP + np.array([0, 999_999_957, 999_999_958, 5 * 10**9])
    rows = chance.normal(size=(4, 6))
    make = repeated(lambda stamp, values: wrench(stamp, "tool", values), stamps, rows)
    for number in (3, 0, 2, 1):
        assert make(number) == wrench(int(stamps[number]), "tool", rows[number])
        assert parts(make(number)) == (*divmod(int(stamps[number]), 10**9), tuple(rows[number]))
