"""Plays on a real Dask cluster are those of one process, also where a worker is killed on the way."""

import os
import signal

import numpy as np
import pytest

from tactiledata.calibrate.plan import Node
from tactiledata.calibrate.plays.player import play_nodes
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute import make_scheduler
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0)))
NODES = [Node(0.47, friction, 0.0) for friction in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)]


def press(number):
    """A ball that goes down, to another place for each number, and along."""
    poses = np.tile(np.eye(4), (8, 1, 1))
    poses[:, 2, 3] = np.array([5, -1, -2, -4, -5, -5, -5, -5]) * 1e-4
    poses[:, 0, 3] = 5e-4 * number + np.array([0, 0, 0, 0, 0, 1, 2, 3]) * 1e-4
    touch = GelTouch(Sphere(radius=4e-3), poses)
    return MeasuredTouch(f"{number}", "t", "s", "ball", touch, np.zeros((8, 6)), np.arange(8.0), 50.0)


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
