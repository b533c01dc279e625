"""A camera that is late is found out, and by how much; a recording that cannot tell says nothing."""

import re

import pytest

from tactiledata.ingest.clocks.lag import lag_in_words
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario


def lag_of(tmp_path, late, capture="video"):
    """What ingest says of the lag of a world whose camera stamps are late by so many seconds."""
    world = find_scenario("tiny")
    world["images"] = {"capture": capture, "rate": 30}
    # host = stream + offset, and the offset is not stated: stamps that are late need a negative one
    world["clocks"]["frames"] = {"offset_ns": -round(late * 1e9), "known": False}
    logs = record(load_scenario(world), tmp_path / "logs", "folder")
    report = ingest(logs[:1], tmp_path / "ds.zarr")
    said = [finding for finding in report.sources[0].findings if finding.code == "camera-lag"]
    return said[0].message if said else None


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.06, -0.05])
def test_a_planted_lag_comes_back(late, tmp_path):
    """The estimate is within 25 ms (a frame of the camera is 33 ms) of what was planted, sign included."""
    found = float(re.search(r"is ([+-]\d+) ms", lag_of(tmp_path, late))[1]) / 1000
    assert abs(found - late) < 0.025


@pytest.mark.slow
def test_a_camera_that_is_on_time_has_no_lag(tmp_path):
    """Negative control: without a planted lag none is stated, only how large one could be unseen."""
    assert "camera lag: none seen (less than" in lag_of(tmp_path, 0.0)


@pytest.mark.slow
def test_stop_and_go_tells_no_lag(tmp_path):
    """Negative control: images taken at rest, once a step, cannot tell a lag, and none is claimed."""
    assert lag_of(tmp_path, 0.06, capture="step") is None


@pytest.mark.parametrize(
    ("lag", "frame", "each", "words"),
    [
        (-30, 100, [-30], "none seen (less than 130 ms; frames are 100 ms apart)"),
        (100, 100, [100], "none seen (less than 200 ms"),
        (110, 100, [110], "is +110 ms against the force sensor, give or take 100 ms"),
        (-110, 100, [-110], "is -110 ms against the force sensor, give or take 100 ms"),
        (60, 33, [0, 140], "none seen (less than 130 ms; frames are 33 ms apart; the 2 touches judged one by one"),
        (80, 33, [0, 140], "is +80 ms against the force sensor, give or take 70 ms"),
    ],
)
def test_a_lag_whose_interval_holds_zero_is_none(lag, frame, each, words):
    """Half-width: one frame, or half the spread of the touches; a lag is stated only outside of it."""
    assert words in lag_in_words(lag * 10**6, frame * 1e6, [value * 10**6 for value in each])
