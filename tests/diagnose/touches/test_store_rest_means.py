"""Means over rests of a recorded store: closer to what a sensor without noise reads, by as much as is claimed."""

import numpy as np
import pytest
from recorded_touches import recorded_store

from tactiledata.calibrate.measured import read_measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.touches.rest_means import means_at_rest, rest_spans
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.store_motion import StoreMotion
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow


def read(folder, **imperfections):
    """Measured touches of a recorded world by name, their noise, and positions of their tip."""
    store = Store.open(recorded_store(folder, imperfections=imperfections))
    options = CalibrationOptions()
    opened = OpenedStore.planned(store, options.pads)
    measured, motion = read_measured(opened, options), StoreMotion(opened)
    ways = {touch.uid: motion.places(touch) for touch in opened.plan.touches}
    return {touch.name: (touch, ways[touch.uid]) for touch in measured.touches}, measured.noise


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    noisy, noise = read(tmp_path_factory.mktemp("noisy"))
    exact, _ = read(tmp_path_factory.mktemp("exact"), force_noise=0.0, torque_noise=0.0, force_quantum=1e-6)
    return noisy, exact, noise


def test_means_are_as_near_to_the_truth_as_they_say(recorded):
    """Over all frames at rest, the forces' error about each touch's own zero has the predicted deviation."""
    noisy, exact, noise = recorded
    errors, expected, frames = [], [], 0
    for name, (touch, way) in noisy.items():
        spans = rest_spans(touch.seconds, *way)
        found, true = (means_at_rest(one.seconds, one.wrench, spans, one.readings) for one in (touch, exact[name][0]))
        rows = (found.readings > 0) & (true.readings > 0)
        frames += len(rows)
        if rows.sum() < 3:
            continue
        off = (found.wrench - true.wrench)[rows, :3]
        factors = noise.mean_factors(found.readings[rows])
        weights = 1.0 / factors**2
        off -= (weights[:, None] * off).sum(axis=0) / weights.sum()
        errors.append(off / factors[:, None])
        expected.append(len(off) - 1)
    assert sum(expected) > 0.5 * frames
    squares = sum((off**2).sum(axis=0) for off in errors) / sum(expected)
    np.testing.assert_allclose(np.sqrt(squares), noise.deviations[:3], rtol=0.25)


def test_means_have_far_less_noise_than_frames(recorded):
    """A frame of this world rests 0.1 s or longer: its mean has less than 0.6 of the deviation."""
    noisy, _, noise = recorded
    counts = [
        means_at_rest(touch.seconds, touch.wrench, rest_spans(touch.seconds, *way), touch.readings).readings
        for touch, way in noisy.values()
    ]
    factors = noise.mean_factors(np.concatenate(counts))
    assert np.median(factors[factors < 1]) < 0.6
