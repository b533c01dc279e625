"""A worker of a real Dask cluster that is killed on the way costs its tasks alone: the store has the same bytes."""

import os
import signal

import pytest
from copied_trees import copy_tree
from failing_writers import files
from generators import folder_log
from replay.coarse import options

from tactiledata.ingest.pipeline import ingest
from tactiledata.replay import attach
from tactiledata.replay.attach import replay

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cluster():
    """Two workers, each of which is started anew when it was killed."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        yield cluster


def killing(cluster, killed):
    """A progress that kills both workers once something is done: whatever they hold or work at is lost."""

    def kill(done, total, what=""):
        if done and not killed:
            killed.extend(worker.pid for worker in cluster.workers.values())
            for pid in killed:
                os.kill(pid, signal.SIGKILL)

    return kill


def test_ingest_loses_nothing(cluster, tmp_path):
    """Both workers are killed after the first of five recordings: all are there, as one process would have it."""
    for number in range(5):
        folder_log.write(tmp_path / "logs" / f"run{number}", touches=1, frames=2, seed=number)
    killed = []
    ingest([tmp_path / "logs"], tmp_path / "alone.zarr")
    done = ingest(
        [tmp_path / "logs"],
        tmp_path / "cluster.zarr",
        scheduler=cluster.scheduler_address,
        progress=killing(cluster, killed),
    )
    assert len(killed) == 2
    assert {source.state for source in done.sources} == {"added"}
    assert files(tmp_path / "cluster.zarr") == files(tmp_path / "alone.zarr")


def test_replay_loses_nothing(cluster, tiny_store, tmp_path, monkeypatch):
    """Both workers are killed after the first run of touches: every row is as one process would have it."""
    monkeypatch.setattr(attach, "RUN_TOUCHES", 1)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    killed = []
    alone, together = (copy_tree(tiny_store, tmp_path / name) for name in ("alone.zarr", "cluster.zarr"))
    replay(alone, options())
    replay(together, options(), scheduler=cluster.scheduler_address, progress=killing(cluster, killed))
    assert len(killed) == 2
    assert files(together) == files(alone)
