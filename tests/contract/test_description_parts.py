"""Parts of a description that are read on their own: power, clocks, transforms, additions."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription, _merge
from tactiledata.errors import SchemaError

FORMAT = {"format": "tactiledata-log/1", "sensors": {"D1": {"model": "digit"}}}
MIRROR = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
POSE = {"xyz": [1, 2, 3], "xyzw": [0, 0, 0, 1]}
BALL = {"shape": "sphere", "radius": 0.004}


def described(**facts):
    return LogDescription.checked({**FORMAT, **facts}, "log.yaml")


@pytest.mark.parametrize(
    ("stated", "before", "moment"),
    [([5, 9, 7], 8, 7), ([5, 9, 7], 9, 9), ([5, 9, 7], 4, None), ([5], 5, 5), ([], 9, None), (None, 9, None)],
)
def test_a_sensor_was_switched_on_at_the_last_moment_before(stated, before, moment):
    """The latest stated moment that is not after the one asked for, in whatever order they are stated."""
    facts = {"model": "digit"} if stated is None else {"model": "digit", "power_on_ns": stated}
    description = LogDescription({"sensors": {"D1": facts}})
    assert description.switched_on("D1", before) == moment
    assert description.switched_on("another", before) is None


def test_an_offset_of_zero_is_stated():
    """0 ns is an offset; what is not stated, or called unknown, is none."""
    description = described(clocks={"wrench": {"offset_ns": 0}, "tcp": {"offset_ns": 4, "known": False}, "joints": {}})
    assert description.stated_clock_offset("wrench") == 0
    for stream in ("tcp", "joints", "other"):
        assert description.stated_clock_offset(stream) is None


def test_only_a_description_without_a_document_is_empty():
    """A description that says anything is not empty; an empty one has no sensors, indenters, robot or wrench."""
    nothing = LogDescription()
    assert nothing.is_empty
    assert not described().is_empty
    assert [nothing.sensors, nothing.indenters, nothing.robot, nothing.wrench] == [{}] * 4
    assert nothing.where == ""


def test_an_indenters_pose_leads_to_the_base():
    """The stated pose leads from the indenter to the base."""
    description = described(indenters={"ball": {**BALL, "base_from_indenter": POSE}})
    pose = description.base_from_indenter("ball")
    assert (pose.to, pose.source) == ("base", "ball")
    np.testing.assert_allclose(pose.xyz, [1, 2, 3])


@pytest.mark.parametrize(
    "facts",
    [
        {"robot": {"tcp_from_gel": MIRROR}},
        {"robot": {"tcp_from_gel": POSE, "tcp_from_ft": MIRROR}},
        {"indenters": {"ball": {**BALL, "base_from_indenter": POSE}, "b": {**BALL, "base_from_indenter": MIRROR}}},
    ],
)
def test_every_stated_transform_is_checked(facts):
    """A mirror is refused wherever it stands, behind a good transform too."""
    with pytest.raises(SchemaError, match="not a rigid transform"):
        described(**facts)


@pytest.mark.parametrize(
    ("below", "above", "both"),
    [
        ({"a": {"x": 1, "y": 2}}, {"a": {"y": 3}}, {"a": {"x": 1, "y": 3}}),
        ({"a": {"x": {"p": 1, "q": 2}}}, {"a": {"x": {"q": 3}}}, {"a": {"x": {"p": 1, "q": 3}}}),
        ({"a": {"x": 1}}, {"a": 7}, {"a": 7}),
        ({"a": 7}, {"a": {"x": 1}}, {"a": {"x": 1}}),
        ({"a": [1, 2]}, {"a": [3]}, {"a": [3]}),
        ({}, {"a": {"x": 1}}, {"a": {"x": 1}}),
        ({"a": 1}, {}, {"a": 1}),
    ],
)
def test_only_two_mappings_are_merged(below, above, both):
    """A mapping on a mapping is merged at any depth; otherwise what is above takes the place of what is below."""
    assert _merge(below, above) == both
