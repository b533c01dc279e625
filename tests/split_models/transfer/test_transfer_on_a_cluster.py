"""A store transferred by workers has the bytes of one that a single process made, also where a worker is killed."""

import os
import signal

import numpy as np
import pytest
from failing_writers import files
from small_models import image_vae
from transfer_stores import write_two_sensors

from split_models.transfer.methods import vae_transfer
from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from split_models.transfer.transfer_tasks import TransferTask, stage_task
from tactiledata.errors import StoreError, UsageError
from tactiledata.store.read.targets import Target


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A store of six recordings on two sensors, small pictures."""
    return write_two_sensors(tmp_path_factory.mktemp("source") / "ds.zarr", n_sources=6)


@pytest.fixture(scope="module")
def target():
    rng = np.random.default_rng(9)
    return Target("T1", rng.integers(60, 90, (16, 12, 3)).astype(np.uint8), "made", licence="CC0", model="gelsight_r15")


@pytest.mark.slow
def test_a_cluster_writes_the_bytes_of_one_process(source, target, tmp_path):
    """By pixels with a worker killed on the way, and by a network that travels to the workers: the same files."""
    distributed = pytest.importorskip("distributed")
    killed = []
    network = vae_transfer("latent_on_background", image_vae().eval())
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:

        def kill_one(done, total, what=""):
            if not killed:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)

        for method, progress in ((PIXEL_TRANSFERS["background_swap"], kill_one), (network, None)):
            alone, together = (tmp_path / f"{method.name}-{way}.zarr" for way in ("alone", "together"))
            transfer_store(source, target, method, alone)
            report = transfer_store(
                source, target, method, together, progress=progress, scheduler=cluster.scheduler_address
            )
            assert report.added == 6
            assert files(together) == files(alone)
    assert killed


def test_a_source_that_changed_is_refused(source, target, tmp_path):
    """A worker that opens another store than the transfer began with says so, and stages nothing."""
    task = TransferTask(str(source.location), "another", 0, "run0", tmp_path / "out.zarr", None, 1)
    with pytest.raises(StoreError, match="has changed since the transfer began"):
        stage_task(task)
    assert not (tmp_path / "out.zarr").exists()


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_leaves_nothing(source, target, tmp_path, monkeypatch):
    """A store that was begun for it is gone again, with the folder above; one that was there keeps what it had."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("tactiledata.compute.dask.CONNECT_TIMEOUT", 0.2)
    method, nowhere = PIXEL_TRANSFERS["background_swap"], "tcp://127.0.0.1:9"
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        transfer_store(source, target, method, tmp_path / "transferred" / "new.zarr", scheduler=nowhere)
    assert list(tmp_path.iterdir()) == []
    transfer_store(source, target, method, tmp_path / "new.zarr", sensors=["D1"])
    before = files(tmp_path / "new.zarr")
    transfer_store(source, target, method, tmp_path / "new.zarr", sensors=["D1"], scheduler=nowhere)
    assert files(tmp_path / "new.zarr") == before
