"""Plays on a real Dask cluster are those of one process, also where a worker is killed on the way."""

import os
import signal

import numpy as np
import pytest
from small_plays import NODES, PAD, press

from tactiledata.calibrate.plays.player import play_nodes
from tactiledata.compute import make_scheduler

pytestmark = pytest.mark.slow


def test_a_killed_worker_costs_its_tasks_alone(tmp_path, monkeypatch):
    """One of two workers is killed after the first batch: all plays come, equal to those of one process."""
    distributed = pytest.importorskip("distributed")
    touches = [press(number) for number in range(3)]
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "alone"))
    alone = play_nodes(PAD, "linear", touches, NODES)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cluster"))
    killed = []
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:

        def kill_one(done, total, what=""):
            if done and not killed:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)

        together = play_nodes(
            PAD, "linear", touches, NODES, make_scheduler(address=cluster.scheduler_address), kill_one
        )
    assert killed
    assert list(together) == NODES
    for node in NODES:
        for one, other in zip(alone[node], together[node], strict=True):
            np.testing.assert_array_equal(one.wrench, other.wrench)
            np.testing.assert_array_equal(one.status, other.status)
    assert max(np.nanmax(play.wrench[:, 2]) for play in alone[NODES[0]]) > 0
