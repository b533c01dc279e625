"""What a store tells beside pose and wrench is what the rig did."""

from itertools import pairwise

import numpy as np
import pytest
from recorded_touches import POWERED, recorded_store

from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.effects.touch.imprint import SPREAD, ImprintTable
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.store_facts import StoreFacts
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    store = Store.open(recorded_store(tmp_path_factory.mktemp("world")))
    opened = OpenedStore.planned(store, CalibrationOptions().pads)
    return store, opened.plan.touches, StoreFacts(opened)


def test_gravity_points_down_whatever_way_the_sensor_hangs(recorded):
    """Gravity has 9.81 m/s^2 in every frame, and points out of a gel that looks down."""
    _, planned, facts = recorded
    for touch in planned:
        rows = np.arange(*touch.frames)
        gravity = facts.gravity(touch, rows)
        assert np.linalg.norm(gravity, axis=1) == pytest.approx(9.81)
        # the gel looks down on the indenters: what falls leaves it along +z
        assert (gravity[:, 2] > 9.0).all()


def test_joints_are_those_of_the_arm(recorded):
    """Frames have six joint angles within one turn."""
    _, planned, facts = recorded
    joints = facts.joints(np.arange(*planned[0].frames))
    assert joints.shape[1] == 6
    assert np.abs(joints).max() < 2 * np.pi


def test_time_since_power_on_goes_on_over_touches(recorded):
    """The time since power-on starts at the stated one and rises from touch to touch of a sensor."""
    _, planned, facts = recorded
    for sensor in {touch.sensor for touch in planned}:
        ours = [touch for touch in planned if touch.sensor == sensor]
        starts = np.array([facts.powered(touch, np.arange(*touch.frames))[0] for touch in ours])
        assert POWERED < starts[0] < POWERED + 10
        assert (np.diff(starts) > 0).all()


def test_a_mount_is_a_run_of_one_indenter(recorded):
    """A mount is named after its indenter, and every run of touches with one indenter is a mount of its own."""
    _, planned, facts = recorded
    mounts = [facts.mount(touch) for touch in planned]
    runs = 1 + sum((a.sensor, a.indenter) != (b.sensor, b.indenter) for a, b in pairwise(planned))
    assert len(set(mounts)) == runs
    assert all(mount.startswith(touch.indenter) for mount, touch in zip(mounts, planned, strict=True))


def test_history_counts_what_came_before_at_the_spot(recorded):
    """Earlier depth and earlier contacts at a spot are those of a count over all touches before."""
    store, planned, facts = recorded
    ours = [touch for touch in planned if touch.sensor == planned[0].sensor]
    tips = []
    for touch in ours:
        rows = np.arange(*touch.frames)
        poses = touch.gel_touch(store, 0.0).poses
        places = poses[:, :2, 3]
        depth, count = facts.earlier(touch, places, rows)
        away = np.array([np.linalg.norm(places - place, axis=1) for place, _ in tips]).reshape(-1, len(rows))
        assert np.array_equal(count, (away < 2e-3).sum(axis=0))
        table = ImprintTable.of(touch.solid)
        done = np.array([imprint for _, imprint in tips])[:, None] * np.exp(-((away / SPREAD) ** 2) / 2)
        assert table.imprint(depth) == pytest.approx(done.max(axis=0, initial=0.0), abs=1e-16)
        deepest = int(np.argmin(poses[:, 2, 3]))
        tips.append((places[deepest], table.imprint(-poses[deepest, 2, 3])))
    assert len(ours) > 2


def test_a_store_that_does_not_say_it_is_not_asked(tmp_path):
    """A store without a stream of joints has no joint angles."""
    path = recorded_store(tmp_path, streams={"joints": 0, "tcp": 125, "wrench": 100, "arm_wrench": 0})
    store = Store.open(path)
    opened = OpenedStore.planned(store, CalibrationOptions().pads)
    assert StoreFacts(opened).joints(np.arange(*opened.plan.touches[0].frames)) is None
