"""The contact wrench in readings of a few levels: signs, frames, weights and the words about them."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.ingest.forces.contact import contact_wrench, zeros_at
from tests.ingest.made_takes import signal

START = 1_700_000_000_000_000_000
MS = 1_000_000
SAME = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
TOOL = {"mass": 2.0, "centre_of_gravity": [0.1, 0.0, 0.0]}
WEIGHT = [0, 0, -19.6133, 0, 1.96133, 0]
STATED = {"sign": "load_on_sensor", "gravity": "compensated"}


def described(robot=None, **wrench):
    robot = {"tcp_from_gel": SAME, "tcp_from_ft": SAME} if robot is None else robot
    return LogDescription({"robot": robot, "wrench": wrench}, "test")


def upright(times_ms):
    times_ms = np.asarray(times_ms)
    return signal("tcp", START + times_ms * MS, np.tile([0.4, 0, 0.3, 0, 0, 0, 1.0], (len(times_ms), 1)))


def answer(values, description, tcp=None, spans=()):
    """The contact wrench of a reading every 10 ms, and its findings by code; spans in rows."""
    wrench = signal("wrench", START + np.arange(len(values)) * 10 * MS, values)
    named = [(f"t{row}", START + a * 10 * MS, START + b * 10 * MS) for row, (a, b) in enumerate(spans)]
    found = contact_wrench(description, wrench, tcp, named)
    return found.signal, {finding.code: finding for finding in found.findings}


def touches(*forces):
    """Readings of 20 samples of air and 20 of each contact force (3,) that the gel exerts."""
    values = np.zeros((40 * len(forces) + 100, 6))
    for number, force in enumerate(forces):
        values[40 * number + 20 : 40 * number + 40, :3] = -np.asarray(force, float)
    return values, [(40 * number, 40 * number + 40) for number in range(len(forces))]


def pulls(*forces, sign="load_on_sensor"):
    values, spans = touches(*forces)
    found = answer(values if sign == "load_on_sensor" else -values, described(**{**STATED, "sign": sign}), None, spans)
    return found[1].get("sign-reversed")


def test_what_presses_has_a_positive_fz():
    """The contact wrench is the opposite of the load; a reaction is the opposite of that."""
    values, spans = touches((1, 2, 3))
    for sign, factor in (("load_on_sensor", 1), ("reaction", -1)):
        found, said = answer(factor * values, described(**{**STATED, "sign": sign}), None, spans)
        assert found.values[30].tolist() == [1, 2, 3, 0, 0, 0]
        assert said.keys() == {"zero-from-free-air"}
    _, said = answer(values, described(gravity="compensated"), None, spans)
    assert said["sign-assumed"].severity == "warning"
    assert answer(values, described(gravity="compensated"), None, spans)[0].values[30, 2] == 3


@pytest.mark.parametrize(("largest", "is_said"), [(-0.99, False), (-1.0, True), (-1.01, True), (1.0, False)])
def test_a_touch_of_a_newton_tells_the_sign(largest, is_said):
    """A weaker one does not."""
    assert (pulls((0, 0, largest)) is not None) == is_said


@pytest.mark.parametrize(("force", "is_said"), [((8.6, 0, -5), True), ((8.7, 0, -5), False)])
def test_a_touch_pulls_by_more_than_half_of_its_force(force, is_said):
    """Of (8.6, 0, -5) N a little more than half points into the gel."""
    assert (pulls(force) is not None) == is_said


def test_the_firm_half_of_a_touch_decides():
    """Samples with half of the largest force and more decide, by their median."""
    values, spans = touches((0, 0, -4))
    values[20:34, 2] = -1.99
    assert answer(values, described(**STATED), None, spans)[1].get("sign-reversed") is not None
    values[20:34, 2] = -2.0
    assert answer(values, described(**STATED), None, spans)[1].get("sign-reversed") is None


def test_four_of_five_touches_must_pull():
    """Weak touches do not count; three names are given, and the other sign."""
    down, up, weak = (0, 0, -5), (0, 0, 5), (0, 0, -0.5)
    assert pulls(down, down, down, up) is None
    finding = pulls(down, weak, down, up, down, down)
    assert (finding.severity, finding.stream, finding.count) == ("warning", "wrench", 4)
    assert "in 4 of 5 touches (for example t0, t2, t4) pressing gives" in finding.message
    assert "State wrench.sign: reaction if" in finding.message
    assert "State wrench.sign: load_on_sensor if" in pulls(down, sign="reaction").message
    assert pulls(weak) is None


def test_samples_that_are_not_known_tell_nothing_of_the_sign():
    """A touch of which none is known is no touch."""
    values, spans = touches((0, 0, -5), (0, 0, -5))
    values[20:25, 1] = np.nan
    values[40:80] = np.nan
    found = answer(values, described(**STATED), None, spans)[1]["sign-reversed"]
    assert "in 1 of 1 touches" in found.message


def test_without_the_transforms_the_sign_is_not_judged():
    """Either one is missing: the wrench stays in the frame of the sensor, turned round, and it is said."""
    values, spans = touches((1, 2, -5))
    for robot in ({}, {"tcp_from_gel": SAME}, {"tcp_from_ft": SAME}):
        found, said = answer(values, described(robot, **STATED), None, spans)
        assert said.keys() == {"zero-from-free-air", "frame-unknown"}
        assert (found.frame, found.values[30].tolist()) == ("ft", [1, 2, -5, 0, 0, 0])
        assert found.attributes["torque_about"] == "origin of the ft frame"


def test_torques_are_about_the_origin_of_the_gel():
    """The gel lies 0.1 m along z from the sensor: a load of 1 N along x there has -0.1 N m about y."""
    robot = {"tcp_from_ft": SAME, "tcp_from_gel": {"xyz": [0.0, 0.0, 0.1], "xyzw": [1.0, 0.0, 0.0, 0.0]}}
    values, spans = touches((1, 0, 3))
    found, _ = answer(values, described(robot, **STATED), None, spans)
    # the gel is turned about x by half a turn: y and z change their signs
    assert found.values[30] == pytest.approx([1, 0, -3, 0, 0.1, 0], abs=1e-12)
    assert found.frame == "gel"


def test_what_is_kept_of_a_contact_wrench():
    """The contact wrench says in words where it comes from, and keeps the attributes of the wrench."""
    values, _ = touches((0, 0, 3))
    values[:, 0] = 0.01 * (np.arange(len(values)) % 2)
    wrench = signal("wrench", START + np.arange(len(values)) * 10 * MS, values, clock="log")
    found = contact_wrench(described(**STATED), wrench, None, [("t", START, START + 400 * MS)])
    assert found.signal.attributes == {
        "clock": "log", "derived_from": "wrench", "torque_about": "origin of the gel frame",
        "meaning": "what the gel exerts on the indenter; pressing gives fz > 0 in the gel frame",
        "gravity": "compensated by the recorder",
        "zero": "median of each trajectory's free air before the first touch", "noise_n": round(found.noise, 4),
    }  # fmt: skip
    assert found.noise != found.signal.attributes["noise_n"] or found.noise == 0
    assert found.signal.columns == ("fx", "fy", "fz", "tx", "ty", "tz")


def loaded(rows=100):
    return np.tile(np.array(WEIGHT, float), (rows, 1))


def test_the_weight_of_the_tool_is_taken_off():
    """Stated or assumed, and what is assumed is said."""
    robot = {"tcp_from_gel": SAME, "tcp_from_ft": SAME, "tool": TOOL}
    poses = upright(np.arange(0, 1000, 10))
    found, said = answer(loaded(), described(robot, sign="load_on_sensor", gravity="included"), poses)
    assert np.abs(found.values).max() < 1e-12
    assert said.keys() == {"zero-from-free-air"}
    assert found.attributes["gravity"] == "tool weight subtracted, by mass, centre of gravity and pose"
    _, said = answer(loaded(), described(robot, sign="load_on_sensor"), poses)
    assert said.keys() == {"zero-from-free-air", "gravity-assumed"}
    bare = {**robot, "tool": {"mass": 2.0}}
    _, said = answer(loaded(), described(bare, sign="load_on_sensor", gravity="included"), poses)
    assert said.keys() == {"zero-from-free-air", "centre-of-gravity-assumed"}
    assert {one.severity for code, one in said.items() if code.endswith("-assumed")} == {"warning"}
    found, said = answer(loaded(), described(robot, sign="load_on_sensor", gravity="included"), None)
    assert said.keys() == {"zero-from-free-air", "gravity-not-compensated"}
    assert found.attributes["gravity"] == "not compensated"


def test_where_no_pose_is_near_the_wrench_is_not_known():
    """Moments without a near pose are counted, and the first and the last of them are named."""
    robot = {"tcp_from_gel": SAME, "tcp_from_ft": SAME, "tool": TOOL}
    found, said = answer(loaded(), described(robot, sign="load_on_sensor", gravity="included"), upright([200, 210]))
    lost = np.isnan(found.values).all(axis=1)
    # a pose is held for 0.1 s
    assert np.flatnonzero(~lost).tolist() == list(range(10, 32))
    assert not np.isnan(found.values[~lost]).any()
    finding = said["weight-unknown"]
    assert (finding.severity, finding.stream, finding.count) == ("warning", "wrench", 78)
    assert (finding.start_ns, finding.end_ns) == (START, START + 990 * MS)
    assert "78 of 100 samples have no tcp pose" in finding.message


def test_the_load_of_a_reading_of_zero():
    """Minus the tool's weight at each event, where it is taken off; zero where it is not, or not known."""
    robot = {"tcp_from_ft": SAME, "tool": TOOL}
    poses = upright([0, 10])
    assert zeros_at(described(robot), poses, [START, START + 5]) == pytest.approx(-np.array([WEIGHT, WEIGHT]))
    assert zeros_at(described(robot, gravity="compensated"), poses, [START]).tolist() == [[0.0] * 6]
    assert zeros_at(described(robot), None, [START, START]).tolist() == [[0.0] * 6] * 2
    assert zeros_at(described(robot), poses, []).shape == (0, 6)


def test_a_tare_with_the_weight_on_reads_zero_with_the_weight_on():
    """The sensor is zeroed with the tool in the air: afterwards the contact wrench is the reading."""
    robot = {"tcp_from_gel": SAME, "tcp_from_ft": SAME, "tool": TOOL}
    values = loaded(200)
    values[100:] = 0
    values[150:, 2] = -4
    stated = described(robot, sign="load_on_sensor", gravity="included", tare_ns=[START + 1000 * MS])
    found, said = answer(values, stated, upright(np.arange(0, 2000, 10)))
    assert np.abs(found.values[:150]).max() < 1e-9
    assert found.values[150:, 2] == pytest.approx(np.full(50, 4.0), abs=1e-9)
    assert said == {}
