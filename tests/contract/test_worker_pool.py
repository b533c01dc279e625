"""Worker processes end with the process that started them, however that ends."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from tactiledata.contract.worker_pool import shared_queue, worker_pool

SECONDS = 10.0
"""Within which a worker must be gone; tasks take far longer."""
START_SECONDS = 60.0
"""Within which all workers must have started, on a busy machine too."""
SCHEDULED = """
import time
from tactiledata.compute.local import LocalScheduler

def work(seconds):
    time.sleep(seconds)

if __name__ == "__main__":
    for outcome in LocalScheduler(2).outcomes(work, [600.0] * 4):
        pass
"""
RECORDING = """
import sys
from tactiledata.cli.main import run

if __name__ == "__main__":
    sys.argv = ["tactiledata", "record", "paper", "--out", sys.argv[1], "--workers", "2"]
    run()
"""
PARENTS = {"tasks of a scheduler": (SCHEDULED, 2), "a recording": (RECORDING, 3)}
"""Scripts, and how many processes each starts: a recording has one for its counts."""


def workers_of(pid):
    """Child processes that run tasks; the tracker of shared resources is none."""
    return [
        child
        for child in psutil.Process(pid).children(recursive=True)
        if "resource_tracker" not in " ".join(child.cmdline())
    ]


def wait_until(condition):
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


@pytest.mark.slow
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("work", PARENTS)
def test_workers_end_within_seconds_of_their_parent(tmp_path, work, ending):
    """A parent that is killed, terminated or interrupted alone (not its group) leaves no process behind."""
    content, count = PARENTS[work]
    script = tmp_path / "parent.py"
    script.write_text(content)
    # a shell that runs the tests in the background has its children ignore interrupts; a person's shell does not
    parent = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        assert wait_until(lambda: len(workers_of(parent.pid)) == count)
        workers = workers_of(parent.pid)
        parent.send_signal(ending)
        assert parent.wait(SECONDS) != 0
        assert not psutil.wait_procs(workers, timeout=SECONDS)[1]
        # the tracker of semaphores ends last
        told = parent.stderr.read()
        assert "resource_tracker" not in told
        assert "BrokenProcessPool" not in told
    finally:
        for process in (*(workers_of(parent.pid) if parent.poll() is None else ()), parent):
            process.kill()
        parent.wait()
        parent.stdout.close()
        parent.stderr.close()


def own_process(_):
    return os.getpid()


def begun_file(path):
    """Begin a file, wait, and remove it however this ends."""
    try:
        path.write_text("half")
        time.sleep(100)
    finally:
        path.unlink()


def interrupted_meanwhile(paths):
    """Begin each file in a worker, and be interrupted once all of them are there."""
    with worker_pool(len(paths)) as pool:
        for path in paths:
            pool.submit(begun_file, path)
        end = time.monotonic() + START_SECONDS
        while not all(path.exists() for path in paths):
            assert time.monotonic() < end
            time.sleep(0.01)
        raise KeyboardInterrupt


@pytest.mark.slow
def test_a_worker_removes_what_it_was_writing(tmp_path):
    """A worker removes the file that it was writing when Ctrl-C ends its parent."""
    with pytest.raises(KeyboardInterrupt):
        interrupted_meanwhile([tmp_path / f"{number}.part" for number in range(2)])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_block_without_an_error_finishes_what_was_submitted():
    """Tasks still run when the block ends are finished, and the workers are gone afterwards."""
    with worker_pool(2) as pool:
        futures = [pool.submit(own_process, number) for number in range(6)]
    pids = {future.result(timeout=0) for future in futures}
    assert os.getpid() not in pids
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_a_shared_queue_brings_what_tasks_say():
    """A task of a worker puts, the parent gets; behind the block the process that kept the queue is gone."""
    before = set(workers_of(os.getpid()))
    with shared_queue() as said:
        keepers = [child for child in workers_of(os.getpid()) if child not in before]
        with worker_pool(1) as pool:
            pool.submit(said.put, "three").result(START_SECONDS)
        assert said.get(timeout=START_SECONDS) == "three"
    assert len(keepers) == 1
    assert not psutil.wait_procs(keepers, timeout=SECONDS)[1]
