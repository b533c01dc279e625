"""Stated numbers just below and just above what can be."""

import copy

import pytest
from test_plausible import SOUND

from tactiledata.contract.description import LogDescription
from tactiledata.ingest.checks.plausible import description_findings


def said(place, value):
    """Messages on a sound description in which one value is another one."""
    document = copy.deepcopy(SOUND)
    spot = document
    for key in place[:-1]:
        spot = spot[key]
    spot[place[-1]] = value
    return [(one.code, one.severity, one.message) for one in description_findings(LogDescription(document, "test"))]


def matrix(z):
    return [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, z], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("place", "most", "beyond"),
    [
        (("robot", "tcp_from_gel", "xyz"), [0, -1.5, 0], [0, 0, 1.501]),
        (("robot", "tcp_from_ft"), matrix(1.5), matrix(-1.501)),
        (("robot", "tool", "centre_of_gravity"), [1.5, 0, 0], [0, 1.2, 1.2]),
        (("robot", "tool", "mass"), 30.0, 30.1),
        (("indenters", "ball", "base_from_indenter", "xyz"), [5, 0, 0], [3, 4.1, 0]),
        (("sensors", "D20542", "gel", "thickness"), 0.0999, 0.1),
        (("sensors", "D20542", "gel", "edge_thickness"), 0.00011, 1e-4),
        (("sensors", "D20542", "gel", "outline"), [0.0999, 0.00011], [0.02, 0.1]),
        (("robot", "tcp_from_gel", "xyzw"), [0, 0, 0, 1.0009], [0, 0, 0, 1.0011]),
        (("robot", "tcp_from_gel", "xyzw"), [0, 0, 0.9991, 0], [0, 0, 0.9989, 0]),
    ],
)
def test_numbers_at_their_limit_are_plausible(place, most, beyond):
    """Numbers at their limit are plausible; a little beyond it they are in another unit, or no rotation."""
    assert said(place, most) == []
    [(code, severity, _)] = said(place, beyond)
    assert (code, severity) == ("stated-implausible", "warning")


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("robot", "tcp_from_ft"), matrix(21), "robot.tcp_from_ft.xyz is [0, 0, 21]: more than 1.5 m away"),
        (("robot", "tcp_from_gel"), {"xyz": [0, 0, 2.0]}, "robot.tcp_from_gel.xyz is [0, 0, 2.0]: more than 1.5 m"),
        (
            ("indenters", "ball", "base_from_indenter", "xyz"), [9, 0, 0],
            "indenters.ball.base_from_indenter.xyz is [9, 0, 0]: more than 5 m away",
        ),
        (
            ("sensors", "D20542", "gel", "outline"), [18.4, 25],
            "sensors.D20542.gel is [18.4, 25]: expected 0.0001 to 0.1; lengths are in metres",
        ),
        (("robot", "tool", "mass"), 450, "robot.tool.mass is 450: more than 30 kg"),
        (
            ("robot", "tool", "centre_of_gravity"), [0, 0, 20],
            "robot.tool.centre_of_gravity is [0, 0, 20]: more than 1.5 m from the tcp",
        ),
        (
            ("robot", "tcp_from_gel"), {"xyzw": [0, 0, 0, 2.0]},
            "robot.tcp_from_gel.xyzw is [0, 0, 0, 2.0]: a quaternion of length 2; it was scaled to 1",
        ),
    ],
)  # fmt: skip
def test_the_place_and_the_value_are_named(place, value, message):
    """What is not stated of a pose is no rotation and no way."""
    [(_, _, text)] = said(place, value)
    assert text.startswith(message)


def test_a_way_alone_and_a_turn_alone_are_poses():
    """A way alone and a turn alone are poses, and without tool, gel or poses nothing is doubted."""
    assert said(("robot", "tcp_from_gel"), {"xyz": [0, 0, 0.1]}) == []
    assert said(("robot", "tcp_from_gel"), {"xyzw": [0, 0, 0, 1]}) == []
    assert said(("robot",), {}) == []
    assert said(("robot", "tool"), {"mass": 1.0}) == []
    assert said(("indenters", "ball"), {"shape": "sphere", "radius": 0.004}) == []


def test_placeholders_and_models_are_counted_and_named():
    """Both lists are looked through; two near models are offered."""
    document = {
        "sensors": {"REPLACE-left": {"model": "digit"}, "REPLACED": {"model": "digit"}, "S": {"model": "GelSight R15"}},
        "indenters": {"REPLACE-ball": {"shape": "sphere", "radius": 0.004}},
    }
    found = description_findings(LogDescription(document, "test"))
    assert [(one.code, one.severity, one.count) for one in found] == [
        ("sensor-model-unknown", "warning", 1),
        ("placeholder-left", "warning", 2),
    ]
    assert found[0].message.startswith(
        "sensors.S.model is 'GelSight R15', which is not known: did you mean gelsight_r15?"
    )
    assert found[1].message.startswith("REPLACE-left, REPLACE-ball: a placeholder")


def test_a_model_that_is_not_stated_is_not_known():
    """An empty name is like no other."""
    found = description_findings(LogDescription({"sensors": {"S": {}}}))
    assert [one.code for one in found] == ["sensor-model-unknown"]
    assert "model is ''" in found[0].message
    assert "known are digit" in found[0].message


def test_a_shape_that_is_wrong_in_no_known_way_has_no_hint():
    """Only other words and other letters are hinted at, and a known shape with a wrong size is not."""
    hints = {"Sphere": "small letters: sphere", "BALL": "'BALL' is called sphere here", "sphere": "", "blob": ""}
    for shape, hint in hints.items():
        [(code, severity, text)] = said(("indenters", "ball"), {"shape": shape, "radius": 4.0})
        assert (code, severity) == ("indenter-unusable", "warning")
        assert hint in text
        assert ("called" in text or "letters" in text) == bool(hint)
    assert said(("indenters", "ball"), {"mesh": "ball.stl"}) == []
