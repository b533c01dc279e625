"""A scheduler runs the task of a worker that died once more: what is written is the same, at whatever moment it died.

In place of a cluster, each task is begun in a process that is killed on the way, and then done.
"""

from functools import partial

import numpy as np
import pytest
from failing_writers import is_killed
from small_plays import PAD, press

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.compute.base import Scheduler, attempt
from tactiledata.diagnose.touches.play_grid import play_touches

pytestmark = pytest.mark.slow


class DyingWorkers(Scheduler):
    """Workers of which each dies once at every task; ``killed`` says how many died before they were done."""

    def __init__(self, moments):
        self.rng, self.moments, self.killed = np.random.default_rng(5), moments, 0

    def outcomes(self, function, tasks, ahead=None):
        for task in tasks:
            self.killed += is_killed(partial(attempt, function, task), int(self.rng.integers(self.moments)))
            yield attempt(function, task)


def test_a_diagnosis_loses_no_play(tmp_path, monkeypatch):
    """Plays of a diagnosis, also those of shifted paths, are those of workers of which none died."""
    touches, bounds, workers = [press(0)], find_bounds("paper"), DyingWorkers(5)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "alone"))
    (alone,) = play_touches(PAD, "linear", touches, bounds)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "again"))
    (again,) = play_touches(PAD, "linear", touches, bounds, workers)
    assert workers.killed > 5
    for name in ("level", "by_ratio", "by_friction", "by_shift", "height"):
        np.testing.assert_array_equal(getattr(again, name), getattr(alone, name))
    assert np.nanmax(alone.level) > 0
