"""How the indenter moved, and where the force sensor is, as a store tells it, is what the rig did."""

import numpy as np
import pytest
from recorded_touches import recorded_store

from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.effects.touch.felt_acceleration import FREQUENCIES
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.store_motion import StoreMotion
from tactiledata.rig.scenario.scenario import Robot
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    store = Store.open(recorded_store(tmp_path_factory.mktemp("world")))
    opened = OpenedStore.planned(store, CalibrationOptions().pads)
    return store, opened.plan.touches, StoreMotion(opened)


def test_frames_of_a_step_stand_and_know_the_last_move(recorded):
    """Pictures are taken at rest; where the tip had slid before, pace is that of a slide, and rest a moment's."""
    store, planned, motion = recorded
    slid = 0
    for touch in planned:
        rows = np.arange(*touch.frames)
        found = motion.facts(touch, rows)
        way = np.ptp(touch.gel_touch(store, 0.0).poses[:, :2, 3], axis=0)
        if np.linalg.norm(way) < 2e-4:
            assert (found["pace"] == 0).all()
            continue
        slid += 1
        assert 1e-4 < found["pace"].max() < 2e-2
        assert found["pace"][0] == 0
        stood = found["rest"][found["pace"] > 0]
        assert 0 < np.median(stood) < 5
    assert slid > 2


def test_what_the_tool_feels_is_some_share_of_a_stop_from_its_speed(recorded):
    """Something, and no more than a stop from 20 mm/s, whatever the mode; the poses' own noise of 2 um is in it."""
    _, planned, motion = recorded
    for touch in planned:
        felt = motion.facts(touch, np.arange(*touch.frames))["felt_accelerations"]
        assert felt.shape == (touch.frames[1] - touch.frames[0], len(FREQUENCIES), 3)
        assert 1e-6 < np.abs(felt).max() < 2e-2 * 2 * np.pi * FREQUENCIES[-1]


def test_the_sensor_is_where_the_log_says(recorded):
    """The pose of the force sensor in the gel's frame is that of the log, in every frame."""
    _, planned, motion = recorded
    robot = Robot()
    wanted = (robot.tcp_from_gel.inverse() @ robot.tcp_from_ft).matrix
    found = motion.facts(planned[0], np.arange(*planned[0].frames))["gel_from_sensor"]
    np.testing.assert_allclose(found[0], wanted, atol=1e-6)
    assert len(found) == planned[0].frames[1] - planned[0].frames[0]
