"""What a recording says of itself: clock offsets, transforms, additions laid over it."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.errors import SchemaError, UnknownName

FORMAT = {"format": "tactiledata-log/1", "sensors": {"D20542": {"model": "digit"}}}
MIRROR = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def described(**facts):
    return LogDescription.checked({**FORMAT, **facts}, "log.yaml")


@pytest.mark.parametrize(
    ("clock", "offset"),
    [
        ({"offset_ns": 7}, 7),
        ({"offset_ns": -7, "known": True}, -7),
        ({"offset_ns": 7, "known": False}, 0),
        ({"known": True}, 0),
        ({}, 0),
    ],
)
def test_an_offset_counts_only_where_it_is_known(clock, offset):
    """An offset that the recording itself calls unknown moves no stamp."""
    assert described(clocks={"wrench": clock}).clock_offset("wrench") == offset
    assert described(clocks={"wrench": clock}).clock_offset("tcp") == 0
    assert LogDescription().clock_offset("wrench") == 0


def test_transforms_carry_the_frames_of_their_name():
    """tcp_from_gel leads from gel to tcp; what is not stated is None."""
    description = described(robot={"tcp_from_gel": {"xyz": [0, 0, 0.02], "xyzw": [0, 0, 0, 1]}})
    stated = description.transform("tcp_from_gel")
    assert (stated.to, stated.source) == ("tcp", "gel")
    np.testing.assert_allclose(stated.xyz, [0, 0, 0.02])
    assert description.transform("tcp_from_ft") is None


def test_a_mirror_is_refused_when_the_description_is_checked():
    """A transform that is not rigid never reaches a user of the description."""
    with pytest.raises(SchemaError, match="not a rigid transform"):
        described(robot={"tcp_from_ft": np.reshape(MIRROR, (4, 4)).tolist()})


@pytest.mark.parametrize("xyzw", [[0, 0, 0, 0], [0, 0, 0, 1e7]])
def test_a_rotation_that_is_none_is_refused_with_file_and_place(xyzw):
    """A quaternion of zeros, of the tool or of an indenter, names the file and the path in it."""
    pose = {"xyz": [0, 0, 0], "xyzw": xyzw}
    for facts, path in (
        ({"robot": {"tcp_from_gel": pose}}, "$.robot.tcp_from_gel"),
        ({"indenters": {"ball4": {"shape": "sphere", "radius": 0.004, "base_from_indenter": pose}}},
         "$.indenters.ball4.base_from_indenter"),
    ):  # fmt: skip
        with pytest.raises(SchemaError) as refused:
            described(**facts)
        assert str(refused.value).startswith(f"log.yaml at {path}: ")
        assert (refused.value.facts["file"], refused.value.facts["path"]) == ("log.yaml", path)


def test_an_indenter_that_is_not_described_is_unknown():
    """Asking for the pose of an indenter with a wrong name is an error that lists the names."""
    description = described(indenters={"ball4": {"shape": "sphere", "radius": 0.004}})
    assert description.base_from_indenter("ball4") is None
    with pytest.raises(UnknownName, match="ball4"):
        description.base_from_indenter("bal4")


def test_what_is_added_wins_key_by_key():
    """An addition replaces the keys that it names, keeps the others, and leaves the original as it was."""
    below = described(sensors={"A": {"model": "digit", "shore_00": 75}}, title="one")
    both = below.merged({"sensors": {"A": {"shore_00": 60}, "B": {"model": "digit"}}}, "mapping")
    assert both.sensors == {"A": {"model": "digit", "shore_00": 60}, "B": {"model": "digit"}}
    assert both.document["title"] == "one"
    assert below.sensors["A"]["shore_00"] == 75


def test_an_addition_is_checked_too():
    """An addition that does not fit is refused, with the path inside it."""
    with pytest.raises(SchemaError) as caught:
        described().merged({"sensors": {"A": {"model": "digit", "shore_00": "soft"}}}, "mapping")
    assert caught.value.facts["path"].startswith("$.sensors.A")


@pytest.mark.parametrize("beyond", [2**63, -(2**63), 10**23])
def test_a_time_beyond_64_bits_is_refused(beyond):
    """Nanoseconds are kept as 64-bit integers: a larger number is refused by its place in the document."""
    with pytest.raises(SchemaError, match=r"tare_ns\[0\]"):
        described(wrench={"tare_ns": [beyond]})
    assert described(wrench={"tare_ns": [2**63 - 1]}).wrench["tare_ns"] == [2**63 - 1]
