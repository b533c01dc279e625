"""Workers that are killed on the way cost their tasks alone: what is written has the same bytes.

Those of a real Dask cluster are started anew, and the command goes on; where a local one dies, the command says so.
"""

import json
import multiprocessing
import os
import signal
import time
from types import SimpleNamespace

import pytest
from copied_trees import copy_tree
from failing_writers import files
from generators import folder_log
from replay.coarse import options
from sealed_proofs import REQUEST, said, sealed_proof
from writers import corrected_logs, small_world

from tactiledata.compute import make_scheduler
from tactiledata.errors import TactileDataError
from tactiledata.ingest.pipeline import ingest
from tactiledata.prove.answers import tasks
from tactiledata.prove.run import ProofRun
from tactiledata.prove.seal.verify import verify
from tactiledata.replay import attach
from tactiledata.replay.attach import replay
from tactiledata.rig.record import record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def restarting_cluster():
    """Two workers, each of which is started anew when it was killed.

    A local cluster gives up a worker that is not back after 15 s; on a busy machine a process needs longer to start.
    """
    distributed = pytest.importorskip("distributed")
    patience = pytest.importorskip("dask").config.set({"distributed.deploy.lost-worker-timeout": "600s"})
    with patience, distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture
def cluster(restarting_cluster):
    """The cluster, once both workers are there again after the test before."""
    with pytest.importorskip("distributed").Client(restarting_cluster, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=120)
    return restarting_cluster


def killing(cluster, killed, count=2):
    """A progress that kills workers once something is done: whatever they hold or work at is lost."""

    def kill(done, total, what=""):
        if done and not killed:
            killed.extend([worker.pid for worker in cluster.workers.values()][:count])
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


def test_replacing_loses_nothing(cluster, tmp_path):
    """A worker is killed while recordings are read again: they are replaced as one process would have it."""
    corrected_logs(tmp_path)
    killed = []
    alone, together = (copy_tree(tmp_path / "ds.zarr", tmp_path / name) for name in ("alone.zarr", "cluster.zarr"))
    ingest([tmp_path / "logs"], alone, replace=True)
    done = ingest(
        [tmp_path / "logs"],
        together,
        scheduler=cluster.scheduler_address,
        progress=killing(cluster, killed, 1),
        replace=True,
    )
    assert len(killed) == 1
    assert {source.state for source in done.sources} == {"replaced", "present"}
    assert files(together) == files(alone)


KILLED = "killed"
"""Name of a file beside a proof, which is there once a worker was killed."""


def waiting_answer(task):
    """An answer that names nothing; all but that to the first case wait until a worker was killed."""
    is_first = task.name == min(json.loads(task.folder.seal.read_text())["cases"])
    killed, end = task.folder.path.with_name(KILLED), time.monotonic() + 60.0

    def named(*given):
        while not is_first and not killed.exists() and time.monotonic() < end:
            time.sleep(0.01)
        return SimpleNamespace(document=said([]))

    tasks.played_plan = lambda *given: None
    tasks.named_world = named
    return tasks.answer(task)


def test_a_proof_loses_no_answer(cluster, tmp_path, monkeypatch):
    """A worker is killed after the first answer: each case has one answer, and attempts that gave none are counted."""
    folder = sealed_proof(tmp_path / "proof", cases=3)
    seal, killed = json.loads(folder.seal.read_text()), []
    monkeypatch.setattr("tactiledata.prove.run.answer", waiting_answer)
    kill = killing(cluster, killed, 1)

    def kill_at_work(*done):
        """Kill once both workers have begun cases, which wait for it."""
        end = time.monotonic() + 60.0
        while not killed and sum(len(folder.attempts_of(name)) for name in seal["cases"]) < 3:
            assert time.monotonic() < end, "no second worker began a case"
            time.sleep(0.01)
        kill(*done)
        (tmp_path / KILLED).touch()

    run = ProofRun(folder, REQUEST, tmp_path, make_scheduler(address=cluster.scheduler_address), kill_at_work)
    run.answer(seal)
    run.score()
    assert len(killed) == 1
    found = verify(folder)
    assert (found.faults, found.cases, found.answers) == ((), 6, 6)
    counts = {name: (len(folder.attempts_of(name)), len(folder.answers_of(name))) for name in seal["cases"]}
    assert {answers for _, answers in counts.values()} == {1}
    assert {attempts for attempts, _ in counts.values()} == {1, 2}
    assert any("begun 2 times" in note for note in found.notes)


def test_record_says_so_and_goes_on(tmp_path):
    """A local process that dies ends the command with an error that says so; the same command then ends the same."""
    world = small_world(4)
    record(world, tmp_path / "alone", "folder")
    killed = []

    def kill(done, total):
        # the other process that was started keeps the queue of counts
        for process in multiprocessing.active_children():
            if process.name.startswith("StartedWorker") and not killed:
                killed.append(process.pid)
                os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(TactileDataError, match="a worker process died") as caught:
        record(world, tmp_path / "parted", "folder", kill, workers=2)
    assert (caught.value.exit_code, len(killed)) == (1, 1)
    record(world, tmp_path / "parted", "folder")
    assert files(tmp_path / "parted").items() >= files(tmp_path / "alone").items()
    assert not [name for name in files(tmp_path / "parted").keys() - files(tmp_path / "alone") if ".part" not in name]
