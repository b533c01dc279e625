"""What a recording states is held against what can be: each fault is named, and a sound description says nothing."""

import copy
import re

import numpy as np
import pyarrow as pa
import pytest
import yaml
from copied_trees import copy_tree

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Source, Stamps
from tactiledata.contract.take import FRAME_SCHEMA, TRAJECTORY_SCHEMA, StoredSignal, Take, findings_table
from tactiledata.ingest.checks.plausible import clock_findings, description_findings
from tactiledata.ingest.checks.units_seen import unit_findings
from tactiledata.ingest.pipeline import ingest
from tactiledata.units import SIGNAL_COLUMNS, signal_units

SOUND = {
    "format": "tactiledata-log/1",
    "sensors": {"D20542": {"model": "digit", "gel": {"outline": [0.0184, 0.025], "thickness": 0.0041}}},
    "indenters": {
        "ball": {"shape": "sphere", "radius": 0.004, "base_from_indenter": {"xyz": [0.4, 0, 0], "xyzw": [0, 0, 0, 1]}},
        "cad": {"mesh": "meshes/cad.stl", "unit": "mm"},
    },
    "robot": {
        "tcp_from_gel": {"xyz": [0, 0, 0.021], "xyzw": [0, 0, 0.70711, 0.70711]},
        "tcp_from_ft": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.06], [0, 0, 0, 1]],
        "tool": {"mass": 0.45, "centre_of_gravity": [0, 0, -0.02]},
    },
}


def said(document):
    found = description_findings(LogDescription.checked(document, "test"))
    return [(finding.code, finding.message) for finding in found]


def test_a_sound_description_says_nothing():
    """A sound description gives no finding, also with the corpora's own models, or nothing at all."""
    assert said(SOUND) == []
    assert said({**SOUND, "sensors": {"one": {"model": "gelsight_mini"}}}) == []
    assert description_findings(LogDescription()) == []


@pytest.mark.parametrize(
    ("place", "value", "code", "word"),
    [
        (("indenters", "ball", "radius"), 2.0, "indenter-unusable", "metres"),
        (("indenters", "ball", "radius"), -0.004, "indenter-unusable", "positive"),
        (("indenters", "ball", "diameter"), 0.008, "indenter-unusable", "sizes of sphere: radius"),
        (("indenters", "ball", "shape"), "ball", "indenter-unusable", "'ball' is called sphere here"),
        (("indenters", "cad", "mesh"), "../cad.stl", "indenter-unusable", "leads out of the recording"),
        (("indenters", "cad", "mesh"), "/meshes/cad.stl", "indenter-unusable", "leads out of the recording"),
        (("indenters", "cad", "mesh"), "..\\\\cad.stl", "indenter-unusable", "leads out of the recording"),
        (("indenters", "ball", "shape"), "Sphere", "indenter-unusable", "small letters: sphere"),
        (("indenters", "ball", "shape"), "spere", "indenter-unusable", "Did you mean sphere"),
        (("sensors", "D20542", "model"), "digitt", "sensor-model-unknown", "did you mean digit?"),
        (("sensors", "D20542", "model"), "DIGIT", "sensor-model-unknown", "did you mean digit?"),
        (("sensors", "D20542", "model"), "warpdrive", "sensor-model-unknown", "known are digit"),
        (("sensors", "D20542", "gel", "thickness"), 4.1, "stated-implausible", "sensors.D20542.gel"),
        (("robot", "tcp_from_gel", "xyz"), [0, 0, 21], "stated-implausible", "robot.tcp_from_gel.xyz"),
        (("robot", "tcp_from_gel", "xyzw"), [0, 0, 0.5, 0.5], "stated-implausible", "length 0.7071"),
        (("indenters", "ball", "base_from_indenter", "xyz"), [412, 0, 20], "stated-implausible", "metres"),
        (("robot", "tool", "mass"), 450, "stated-implausible", "kilograms"),
        (("robot", "tool", "centre_of_gravity"), [0, 0, -20], "stated-implausible", "centre_of_gravity"),
        (("sensors", "REPLACE-with-serial-of-digit"), {"model": "digit"}, "placeholder-left", "REPLACE"),
    ],
)
def test_what_cannot_be_is_named(place, value, code, word):
    """One fault in a sound description gives one finding, which says where and what is expected."""
    document = copy.deepcopy(SOUND)
    spot = document
    for key in place[:-1]:
        spot = spot[key]
    spot[place[-1]] = value
    [(found, message)] = said(document)
    assert found == code
    assert word in message


def take_with(name, values, units=None, columns=None):
    columns = columns or SIGNAL_COLUMNS[name]
    t_ns = np.arange(len(values)) * 10_000_000
    signal = StoredSignal(t_ns, values, columns, units or signal_units(columns), "", Stamps(t_ns))
    touch = dict.fromkeys(TRAJECTORY_SCHEMA.names) | {"trajectory": "t0", "start_ns": 0, "end_ns": 10**9}
    trajectories = pa.Table.from_pylist([touch], TRAJECTORY_SCHEMA)
    return Take(
        Source("run", "run", "mcap", ()), "ab", "ok", {}, {}, FRAME_SCHEMA.empty_table(), trajectories,
        findings_table([]), {name: signal},
    )  # fmt: skip


def press():
    """A press of 5 N with a lever of 6 cm, with the noise of an FT 300-S."""
    wrench = np.random.default_rng(1).normal(0, [0.1] * 3 + [0.005] * 3, (400, 6))
    wrench[150:250] += [0, 0, -5, 0.3, 0, 0]
    return wrench


POSE = np.tile([0.4, -0.1, 0.3, 0, 0, 0, 1.0], (50, 1))
JOINTS = np.tile([0.1, -1.57, 1.57, -1.57, -6.2, 0.0], (50, 1))


@pytest.mark.parametrize(
    ("name", "values", "factors", "word"),
    [
        ("tcp", POSE, [1000] * 3 + [1] * 4, "millimetres"),
        ("joints", JOINTS, [57.3] * 6, "degrees"),
        ("wrench", press(), [0.001] * 6, "kilonewtons"),
        ("wrench", press(), [1] * 3 + [1000] * 3, "newton millimetres"),
    ],
)
def test_another_unit_is_noticed(name, values, factors, word):
    """Numbers in another unit give a finding that names it; the same numbers in SI give none."""
    assert unit_findings(take_with(name, values)) == []
    [finding] = unit_findings(take_with(name, values * factors))
    assert finding.code == "unit-implausible"
    assert word in finding.message


@pytest.mark.parametrize(("unit", "number"), [("K", 1), ("degC", 0), ("K", 0)])
def test_kelvin_that_are_celsius(unit, number):
    """25 in kelvin is colder than any lab; 298 is not, and degrees may be 25."""
    values = np.full((20, 1), 25.0 if number or unit == "degC" else 298.0)
    assert len(unit_findings(take_with("gel", values, (unit,), ("temperature",)))) == number


def test_free_motion_is_no_doubt():
    """Noise alone, a sensor at exactly zero, or samples that are all NaN give no finding."""
    noise = press()
    noise[150:250] = noise[:100]
    for values in (noise, np.zeros((50, 6)), np.full((50, 6), np.nan)):
        assert unit_findings(take_with("wrench", values)) == []


@pytest.mark.parametrize(
    ("clocks", "says"),
    [
        (["wrench", "tcp", "joints", "frames", "loads"], []),
        (["contact_wrench"], ["clocks.contact_wrench is of no stream"]),
        (["wrech"], ["clocks.wrech is of no stream .*; did you mean wrench\\?"]),
        (["digit"], ["clocks.digit is .*: there are frames, loads, wrench. Images of all cameras go by frames"]),
        (["frame", "x"], ["clocks.frame .* did you mean frames", "clocks.x .* there are"]),
    ],
)
def test_a_clock_of_no_stream_is_named(clocks, says):
    """Its offset would do nothing; streams that a log may have and this one has not are left in peace."""
    document = {**SOUND, "clocks": {name: {"offset_ns": 5, "known": True} for name in clocks}}
    found = clock_findings(LogDescription.checked(document, "test"), {"wrench": 0, "loads": 0, "contact_wrench": 0})
    assert [one.code for one in found] == ["clock-unknown"] * len(says)
    for one, pattern in zip(found, says, strict=True):
        assert re.search(pattern, one.message)


@pytest.mark.slow
def test_a_take_with_a_clock_of_no_stream_says_so(tiny_folders, tmp_path):
    """The finding is among those of ingest, with the streams that the recording has."""
    copy_tree(tiny_folders[0], tmp_path / "log")
    path = tmp_path / "log" / "log.yaml"
    document = yaml.safe_load(path.read_text())
    document["clocks"]["wrnech"] = {"offset_ns": 10**9, "known": True}
    path.write_text(yaml.safe_dump(document))
    [finding] = [
        one
        for one in ingest([tmp_path / "log"], tmp_path / "a.zarr").sources[0].findings
        if one.code == "clock-unknown"
    ]
    assert "did you mean wrench?" in finding.message
