"""Serials of images and trajectories, with the words about those that are not known."""

import numpy as np
import pyarrow as pa

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.ingest.trajectories.frames import CapturedFrames
from tactiledata.ingest.trajectories.identity import name_sensors, sensor_facts

SHA = "0123456789abcdef"


def named(sensors, trajectories=(), cameras=None, names=None):
    """Sensors of images at 0, 1, 2... ns, of trajectories, and the findings."""
    cameras = cameras or ["digit"] * len(sensors)
    table = pa.table({
        "camera": pa.array(cameras, pa.string()), "trajectory": pa.array(names or [""] * len(cameras), pa.string()),
    })  # fmt: skip
    captured = CapturedFrames(table, np.arange(len(cameras)), list(sensors), {}, [])
    recording = Recording(Source("p", "k", "folder", ()), LogDescription())
    said = []
    found, touches = name_sensors(recording, captured, tuple(trajectories), SHA, said.append)
    return found, [touch.sensor for touch in touches], said


def test_an_interval_lends_its_sensor_half_open():
    """An interval lends its sensor from its start on and not at its end; one without a sensor lends nothing."""
    touches = [Trajectory("a", 0, 2), Trajectory("b", 1, 3, "D1"), Trajectory("c", 2, 5, "D2")]
    found, _, said = named(["", "", "", "", "", ""], touches)
    assert found == ["unknown-01234567", "D1", "D1", "D2", "D2", "unknown-01234567"]
    assert [(one.code, one.count) for one in said] == [("sensor-unknown", 2), ("trajectory-of-several-sensors", 1)]


def test_a_trajectory_that_is_named_lends_its_sensor():
    """Before the one whose interval the image lies in; the image's own serial stands above both."""
    touches = [Trajectory("a", 0, 2, "D1"), Trajectory("b", 5, 9, "D2")]
    assert named(["", "D7", ""], touches, names=["b", "b", "nobody"])[0][:2] == ["D2", "D7"]
    assert named(["D7", ""], touches, names=["", "b"])[0] == ["D7", "D2"]


def test_images_of_nobody_are_counted_and_their_names_said():
    """One camera goes by the digest, several by their names too, in order."""
    found, _, [said] = named(["D1", "", ""])
    assert found == ["D1", "unknown-01234567", "unknown-01234567"]
    assert (said.code, said.severity, said.count) == ("sensor-unknown", "warning", 2)
    assert said.message.startswith("2 of 3 images do not say which sensor took them; they are filed under 'unknown-0")
    _, _, [said] = named(["", ""], cameras=["right", "left"])
    assert "under 'unknown-01234567-left' and 'unknown-01234567-right'. Name" in said.message
    assert named(["D1"])[2] == []


def test_a_trajectory_is_called_after_the_sensor_inside_it():
    """Half-open, none where there are no images inside; its own name stays."""
    touches = [Trajectory("a", 0, 2), Trajectory("b", 2, 3), Trajectory("c", 3, 9), Trajectory("d", 0, 9, "D9")]
    assert named(["D2", "D2", "D3"], touches)[1] == ["D2", "D3", "", "D9"]


def test_a_trajectory_of_several_sensors_is_one_for_each():
    """No unit is made up of two serials: each sensor has a trajectory of the same span, under a name of its own."""
    touches = [Trajectory("a", 0, 2), Trajectory("a-D2", 4, 5), Trajectory("b", 2, 3)]
    recording = Recording(Source("p", "k", "folder", ()), LogDescription())
    table = pa.table({"camera": ["x", "y", "y"], "trajectory": ["", "", ""]})
    said = []
    captured = CapturedFrames(table, np.arange(3), ["D2", "D1", "D3"], {}, [])
    _, found = name_sensors(recording, captured, tuple(touches), SHA, said.append)
    assert [(one.name, one.sensor, one.start_ns, one.end_ns) for one in found] == [
        ("a-D1", "D1", 0, 2),
        ("a-D2~2", "D2", 0, 2),
        ("a-D2", "", 4, 5),
        ("b", "D3", 2, 3),
    ]
    assert [(one.code, one.severity, one.count) for one in said] == [("trajectory-of-several-sensors", "warning", 1)]
    assert "(a): each is kept once a sensor, as 'a-<serial>'" in said[0].message


def test_three_trajectories_of_several_sensors_are_named():
    """A fourth is a sign; the first one is the example, and a name that is taken twice is numbered on."""
    for count, ending in ((3, "(a, b, c): each"), (4, "(a, b, c …): each")):
        touches = [Trajectory(name, 2 * number, 2 * number + 2) for number, name in enumerate("abcd"[:count])]
        _, sensors, [said] = named(["D1", "D2"] * count, touches)
        assert sensors == ["D1", "D2"] * count
        assert said.count == count
        assert said.message.startswith(f"{count} trajectories name no sensor and hold images of several {ending}")
        assert "as 'a-<serial>'" in said.message
    captured = CapturedFrames(
        pa.table({"camera": ["x", "y"], "trajectory": ["", ""]}), np.arange(2), ["D1", "D2"], {}, []
    )
    taken = (Trajectory("a", 0, 2), Trajectory("a-D2", 5, 6, "D2"), Trajectory("a-D2~2", 6, 7, "D2"))
    _, found = name_sensors(
        Recording(Source("p", "k", "folder", ()), LogDescription()), captured, taken, SHA, [].append
    )
    assert [one.name for one in found] == ["a-D1", "a-D2~3", "a-D2", "a-D2~2"]


def test_without_images_the_only_sensor_is_that_of_all_trajectories():
    """Where another trajectory names one; two that are named, or none, lend nothing."""
    touches = [Trajectory("a", 0, 2), Trajectory("b", 2, 3, "D1")]
    assert named([], touches)[1] == ["D1", "D1"]
    assert named([], [*touches, Trajectory("c", 5, 6, "D2")])[1] == ["", "D1", "D2"]
    assert named([], touches[:1])[1] == [""]


def test_a_serial_of_two_cameras_is_named_with_them():
    """Once for each serial, with the first camera's name; images of nobody share nothing."""
    _, _, said = named(["D2", "D2", "D1", "D1", "D1", "", ""], cameras=["b", "a", "c", "b", "a", "x", "y"])
    assert [(one.code, one.severity, one.stream, one.count) for one in said[:2]] == [
        ("serial-shared", "damage", "a", 3),
        ("serial-shared", "damage", "a", 2),
    ]
    assert said[0].message.startswith("the cameras a, b, c say that they are the one sensor 'D1'")
    assert [one.code for one in said[2:]] == ["sensor-unknown"]


def test_facts_of_sensors_leave_out_files_and_moments():
    """What the description says of each serial; nothing of one it does not know, or that has no name."""
    document = {"sensors": {"D1": {"model": "digit", "background": "a.png", "power_on_ns": [5], "licence": "MIT"}}}
    assert sensor_facts(LogDescription(document), ["D1", "D2", ""]) == {
        "D1": {"model": "digit", "licence": "MIT"},
        "D2": {},
    }
