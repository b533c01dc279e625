"""Scenario files: what is accepted, what is refused and how, what is drawn."""

import copy
import sys

import pytest

from tactiledata.cli.main import run
from tactiledata.errors import SchemaError, UnknownName
from tactiledata.rig.record import log_groups, record
from tactiledata.rig.scenario.generate import touches
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import bundled_worlds, find_scenario

MINIMAL = {
    "format": "tactiledata-scenario/1",
    "sensors": {"A": {"background": "digit-bg-0"}, "B": {"background": "digit-bg-1"}},
    "indenters": {"ball": {"shape": "sphere"}, "ring": {"shape": "ring"}, "dots": {"shape": "dots"}},
    "generate": {"count": 12},
}
TOUCH = {"name": "one", "sensor": "A", "indenter": "ball", "steps": [{"press": {"depth": 0.0005}}]}


def changed(**changes):
    return {**copy.deepcopy(MINIMAL), **changes}


def test_the_help_of_record_lists_the_bundled_worlds(capsys, monkeypatch):
    """The help of `record` lists every bundled world."""
    monkeypatch.setattr(sys, "argv", ["tactiledata", "record", "--help"])
    with pytest.raises(SystemExit):
        run()
    told = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert f"bundled scenario: {', '.join(sorted(bundled_worlds()))}." in told


@pytest.mark.parametrize("name", ["demo", "paper", "tiny"])
def test_bundled_worlds_are_valid(name):
    """Every bundled scenario loads, and groups into logs with names of their own."""
    assert name in bundled_worlds()
    groups = log_groups(load_scenario(find_scenario(name)))
    assert len({group[0] for group in groups}) == len(groups)


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"format": "tactiledata-scenario/9"}, "$.format"),
        ({"sensors": {}}, "$.sensors"),
        ({"sensors": {"A": {}}}, "$.sensors.A"),
        ({"material": {"poisson_ratio": 0.5}}, "$.material.poisson_ratio"),
        ({"contact": "magic"}, "$.contact"),
        ({"contact_pitch": 0.4}, "$.contact_pitch"),
        ({"images": {"encoding": "gif"}}, "$.images.encoding"),
        ({"streams": {"wrench": 0}}, "$.streams.wrench"),
        ({"images": {"capture": "video", "rate": 0}}, "$.images.rate"),
        ({"generate": {"count": 0}}, "$.generate.count"),
        ({"generate": {"count": 1, "depth": [0.002, 0.001]}}, "$.generate.depth"),
        ({"generate": {"count": 1, "sensors": ["C"]}}, "$.generate.sensors[0]"),
        ({"generate": {"count": 1, "position": [0.1, 0.0]}}, "$.generate.position"),
        ({"trajectories": [{**TOUCH, "sensor": "C"}]}, "$.trajectories[0].sensor"),
        ({"trajectories": [{**TOUCH, "indenter": "C"}]}, "$.trajectories[0].indenter"),
        ({"trajectories": [TOUCH, TOUCH]}, "$.trajectories[1].name"),
        ({"trajectories": [{**TOUCH, "position": [0.02, 0.0]}]}, "$.trajectories[0].position"),
        ({"trajectories": [{**TOUCH, "steps": [{"jump": {}}]}]}, "$.trajectories[0].steps[0]"),
        ({"colour": "red"}, "$"),
    ],
)
def test_a_fault_is_named_by_its_place(changes, path):
    """Each fault is a SchemaError with the path inside the document."""
    with pytest.raises(SchemaError) as caught:
        load_scenario(changed(**changes))
    assert caught.value.facts["path"] == path


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"robot": {"tcp_from_gel": {"xyz": [0, 0, 0], "xyzw": [0, 0, 0, 0]}}}, "$.robot.tcp_from_gel"),
        (
            {"indenters": {"ball": {"shape": "sphere", "radius": 0.004,
                                    "base_from_indenter": {"xyz": [0, 0, 0], "xyzw": [0, 0, 0, 0]}}}},
            "$.indenters.ball.base_from_indenter",
        ),
    ],
)  # fmt: skip
def test_a_rotation_of_zeros_is_refused_by_its_place(changes, path):
    """A quaternion without a length, of the robot or of an indenter: file, place and what was expected."""
    with pytest.raises(SchemaError, match=r"expected a unit quaternion x y z w") as caught:
        load_scenario(changed(**changes))
    assert str(caught.value).startswith(f"the scenario, at {path}: rotation of ")


def test_nothing_to_play_is_refused():
    """A scenario with neither trajectories nor generate is refused."""
    document = changed()
    del document["generate"]
    with pytest.raises(SchemaError, match="neither"):
        load_scenario(document)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"sensors": {"A": {"background": "digit-bg-99"}}}, UnknownName),
        ({"sensors": {"A": {"background": "../../secret.png"}}}, ValueError),
        ({"indenters": {"ball": {"shape": "spere"}}}, SchemaError),
        ({"indenters": {"ball": {"shape": "sphere", "radius": 4.0}}}, SchemaError),
        ({"sensors": {"truth": {"background": "digit-bg-0"}}}, SchemaError),
    ],
)
def test_what_the_schema_cannot_see_is_an_error_too(tmp_path, changes, error):
    """Unknown backgrounds and shapes, sizes in millimetres, a name that collides: before anything is written."""
    with pytest.raises(error):
        record(load_scenario(changed(**changes, generate={"count": 1})), tmp_path / "out", "folder")
    assert not list((tmp_path / "out").glob("[!.]*"))


def test_a_background_of_another_size_is_refused(tmp_path):
    """An image that no DIGIT takes."""
    import cv2
    import numpy as np

    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((240, 320, 3), np.uint8))
    scenario = load_scenario(changed(sensors={"A": {"background": "small.png"}}, generate={"count": 1}), tmp_path)
    with pytest.raises(SchemaError, match="240 rows x 320 columns"):
        record(scenario, tmp_path / "out")


def test_more_touches_leave_the_first_as_they_were():
    """A larger count adds touches and changes none."""
    few = touches(load_scenario(changed(generate={"count": 5})))
    many = touches(load_scenario(changed(generate={"count": 30})))
    assert many[:5] == few


def test_every_sensor_meets_every_indenter():
    """Touches are dealt evenly."""
    met = {(touch.sensor, touch.indenter) for touch in touches(load_scenario(changed()))}
    assert len(met) == 6


def test_paired_touches_differ_in_the_sensor_only():
    """`paired` gives the same touch on every sensor, tied by its group."""
    from dataclasses import replace

    drawn = touches(load_scenario(changed(generate={"count": 3, "paired": True})))
    assert len(drawn) == 6
    for first, second in zip(drawn[::2], drawn[1::2], strict=True):
        assert (first.sensor, second.sensor) == ("A", "B")
        assert replace(second, name=first.name, sensor="A") == first
        assert first.group == second.group


def test_some_touches_may_be_paired():
    """`paired: 2`: the first two are made on both sensors, with their own indenters; the others are dealt as ever."""
    plan = {"count": 6, "paired": 2, "paired_indenters": ["box"]}
    indenters = {"ball": {"shape": "sphere"}, "box": {"shape": "box"}}
    drawn = touches(load_scenario(changed(generate=plan, indenters=indenters)))
    assert [touch.name for touch in drawn[:5]] == ["t00000-A", "t00000-B", "t00001-A", "t00001-B", "t00002"]
    assert len(drawn) == 2 * 2 + 4
    assert {touch.indenter for touch in drawn[:4]} == {"box"}
    assert {(touch.sensor, touch.indenter) for touch in drawn[4:]} == {(s, i) for s in "AB" for i in indenters}
    alone = touches(
        load_scenario(changed(generate={**plan, "sensors": ["A"], "paired_sensors": ["A", "B"]}, indenters=indenters))
    )
    assert [touch.sensor for touch in alone] == ["A", "B", "A", "B", "A", "A", "A", "A"]
    with pytest.raises(SchemaError, match=r"generate\.paired_sensors\[0\]"):
        load_scenario(changed(generate={**plan, "paired_sensors": ["C"]}, indenters=indenters))
    with pytest.raises(SchemaError, match=r"generate\.paired_indenters\[0\]"):
        load_scenario(changed(generate={**plan, "paired_indenters": ["cone"]}, indenters=indenters))
