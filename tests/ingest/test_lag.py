"""A camera that is late is found out, and by how much; a recording that cannot tell says nothing."""

import re

import pytest

from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario import load_scenario
from tactiledata.rig.worlds import find_scenario


def lag_of(tmp_path, late, capture="video"):
    """What ingest says of the lag of a world whose camera stamps are late by so many seconds."""
    world = find_scenario("tiny")
    world["images"] = {"capture": capture, "rate": 30}
    # host = stream + offset, and the offset is not stated: stamps that are late need a negative one
    world["clocks"]["frames"] = {"offset_ns": -round(late * 1e9), "known": False}
    logs = record(load_scenario(world), tmp_path / "logs", "folder")
    report = ingest(logs[:1], tmp_path / "ds.zarr")
    said = [finding for finding in report.sources[0].findings if finding.code == "camera-lag"]
    return float(re.search(r"is ([+-]\d+) ms", said[0].message)[1]) / 1000 if said else None


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.0, 0.06, -0.05])
def test_a_planted_lag_comes_back(late, tmp_path):
    """The estimate is within 25 ms (a frame of the camera is 33 ms) of what was planted, sign included."""
    found = lag_of(tmp_path, late)
    assert found is not None
    assert abs(found - late) < 0.025


@pytest.mark.slow
def test_stop_and_go_tells_no_lag(tmp_path):
    """Negative control: images taken at rest, once a step, cannot tell a lag, and none is claimed."""
    assert lag_of(tmp_path, 0.06, capture="step") is None
