"""Every scheduler gives the same outcomes in the order of the tasks."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tactiledata.compute import SCHEDULERS, make_scheduler
from tactiledata.compute.dask import CONNECT_TIMEOUT
from tactiledata.errors import BrokenLog, TactileDataError, UsageError


def halve(number):
    if number % 2:
        raise BrokenLog(f"{number} is odd", "an even number", "Add one.", number=number)
    return number // 2


def die(number):
    if number == 3:
        os._exit(1)
    return number


class Keeping:
    """A task that keeps of its work what no process can send."""

    def work(self):
        """Keep a function, and say how many are kept."""
        self.kept = lambda: None
        return len(vars(self))


def met(task):
    """Whether the last of nine tasks ran while the first one waited for it, at most so many seconds."""
    number, folder, seconds = task
    if number == 8:
        (folder / "last").touch()
    end = time.monotonic() + seconds
    while number == 0 and not (folder / "last").exists() and time.monotonic() < end:
        time.sleep(0.01)
    return (folder / "last").exists()


def check(outcomes):
    assert [outcome.task for outcome in outcomes] == list(range(10))
    assert [outcome.result for outcome in outcomes if outcome.is_ok] == [0, 1, 2, 3, 4]
    odd = [outcome.error for outcome in outcomes if not outcome.is_ok]
    assert [error.facts["number"] for error in odd] == [1, 3, 5, 7, 9]
    assert str(odd[0]) == "1 is odd; expected an even number. Add one."


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_local_outcomes_keep_order_and_errors(workers):
    """Results and errors come in task order, whether in this process or on others."""
    check(list(SCHEDULERS["local"](workers).outcomes(halve, range(10))))


@pytest.mark.slow
def test_only_results_come_back_from_workers():
    """A task keeps a function, which no process could send; its outcome has the task that was sent, untouched."""
    tasks = [Keeping(), Keeping()]
    outcomes = list(SCHEDULERS["local"](2).outcomes(Keeping.work, tasks))
    assert [outcome.result for outcome in outcomes] == [1, 1]
    assert all(outcome.task is task and not vars(task) for outcome, task in zip(outcomes, tasks, strict=True))


@pytest.mark.slow
def test_a_slow_task_does_not_hold_up_the_others(tmp_path):
    """All tasks are begun while the first one runs, if the caller allows it; otherwise only a few are."""
    (tmp_path / "few").mkdir()
    few = [(number, tmp_path / "few", 0.5) for number in range(9)]
    assert not next(iter(SCHEDULERS["local"](2).outcomes(met, few))).result
    tasks = [(number, tmp_path, 60.0) for number in range(9)]
    assert next(iter(SCHEDULERS["local"](2).outcomes(met, tasks, len(tasks)))).result


@pytest.mark.slow
def test_dask_outcomes_equal_local_ones():
    """A real Dask cluster gives what local processes give."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        scheduler = SCHEDULERS["dask"](cluster.scheduler_address)
        check(list(scheduler.outcomes(halve, range(10))))
        # only results come back
        tasks = [Keeping(), Keeping()]
        outcomes = list(scheduler.outcomes(Keeping.work, tasks))
    assert [outcome.result for outcome in outcomes] == [1, 1]
    assert all(outcome.task is task and not vars(task) for outcome, task in zip(outcomes, tasks, strict=True))


@pytest.mark.slow
def test_a_worker_that_dies_is_named():
    """A worker killed by the system ends the run with advice, not a traceback of the pool."""
    with pytest.raises(TactileDataError, match="memory"):
        list(SCHEDULERS["local"](2).outcomes(die, range(8)))


def process_of(number):
    return os.getpid()


@pytest.mark.slow
def test_processes_that_are_kept_open_serve_every_run():
    """Within the block two runs have the same processes, which end with it; before and after, each run has its own."""
    runner = SCHEDULERS["local"](2)

    def processes():
        return {outcome.value for outcome in runner.outcomes(process_of, range(40))}

    with runner.kept_open() as kept:
        assert kept is runner
        together = processes() | processes()
        check(list(runner.outcomes(halve, range(10))))
    assert len(together) <= 2
    assert os.getpid() not in together
    assert not processes() & together
    for process in together:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)
    with make_scheduler(1).kept_open() as alone:
        assert {outcome.value for outcome in alone.outcomes(process_of, range(3))} == {os.getpid()}


@pytest.mark.slow
def test_a_run_after_a_worker_died_has_processes_again():
    """A worker that is killed ends its run with advice; the next run within the block starts processes of its own."""
    runner = SCHEDULERS["local"](2)
    with runner.kept_open():
        with pytest.raises(TactileDataError, match="memory"):
            list(runner.outcomes(die, range(8)))
        check(list(runner.outcomes(halve, range(10))))


def slow_mark(task):
    number, folder = task
    time.sleep(0.2)
    (folder / str(number)).touch()
    return number


@pytest.mark.slow
def test_tasks_that_nobody_waits_for_any_more_are_not_begun(tmp_path):
    """Worker processes that stay open skip the queued tasks of a run whose results are no longer read."""
    runner = SCHEDULERS["local"](2)
    with runner.kept_open():
        run = runner.outcomes(slow_mark, [(number, tmp_path) for number in range(40)], 40)
        assert next(run).value == 0
        run.close()
        assert [outcome.value for outcome in runner.outcomes(halve, [4, 6])] == [2, 3]
    assert len(list(tmp_path.iterdir())) < 12


def test_zero_workers_is_refused():
    """Zero workers is a usage error."""
    with pytest.raises(UsageError, match="at least 1"):
        SCHEDULERS["local"](0)


def test_workers_beside_a_cluster_are_refused():
    """A number of local processes would be ignored; one is what no option says."""
    with pytest.raises(UsageError, match="--workers 4 beside --scheduler tcp://here:1"):
        make_scheduler(4, "tcp://here:1")
    assert make_scheduler(1, "tcp://here:1").address == "tcp://here:1"


def test_absent_dask_scheduler_is_a_usage_error(monkeypatch):
    """An address where nobody listens gives advice."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("tactiledata.compute.dask.CONNECT_TIMEOUT", 0.5)
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        list(SCHEDULERS["dask"]("tcp://127.0.0.1:9").outcomes(halve, range(2)))


@pytest.mark.slow
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "tcp://no-such-machine.invalid:8786"])
def test_where_nobody_listens_nobody_waits_long(address):
    """A refused connection and an unknown machine are told within seconds, not after the time of a slow network."""
    pytest.importorskip("distributed")
    began = time.monotonic()
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        list(SCHEDULERS["dask"](address).outcomes(halve, range(2)))
    assert time.monotonic() - began < 0.8 * CONNECT_TIMEOUT


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", "http://127.0.0.1:8786"])
def test_what_is_no_address_is_refused_at_once(address):
    """No client is made for it, which would wait to be closed and end in a traceback."""
    pytest.importorskip("distributed")
    began = time.monotonic()
    with pytest.raises(UsageError, match=r"no Dask scheduler answers .*tcp://host:8786"):
        list(SCHEDULERS["dask"](address).outcomes(halve, range(2)))
    assert time.monotonic() - began < 10.0


@pytest.mark.slow
def test_a_task_that_kills_every_worker_is_named():
    """A task at which workers die again and again ends the run with advice that names it."""
    distributed = pytest.importorskip("distributed")
    with (
        pytest.importorskip("dask").config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as cluster,
        pytest.raises(TactileDataError, match="died again and again at 0"),
    ):
        list(SCHEDULERS["dask"](cluster.scheduler_address).outcomes(end_process, range(1)))


def end_process(number):
    os._exit(1)


@pytest.mark.slow
def test_a_lost_scheduler_and_lost_workers_are_said(monkeypatch, caplog, tmp_path):
    """No workers at the start are wrong usage; workers or a scheduler lost on the way end the run with advice.

    So it is for workers that are lost at a task, and for those that are lost between a task's end and its result.
    """
    pytest.importorskip("distributed")
    started = []

    def start(program, *words):
        command = [sys.executable, "-m", f"distributed.cli.dask_{program}", *words, "--no-dashboard"]
        started.append(subprocess.Popen(command, stderr=subprocess.PIPE, text=True))
        return started[-1]

    try:
        scheduler = start("scheduler", "--port", "0")
        address = next(found[0] for line in scheduler.stderr if (found := re.search(r"tcp://[\d.]+:\d+", line)))
        with monkeypatch.context() as patch:
            patch.setattr("tactiledata.compute.dask.WORKER_TIMEOUT", 0.5)
            with pytest.raises(UsageError, match="has no workers"):
                list(SCHEDULERS["dask"](address).outcomes(halve, range(2)))
        waited = [record.getMessage() for record in caplog.records if record.name == "tactiledata.compute.dask"]
        assert waited == [f"waiting for workers at {address}, for up to 0.5 s"]
        worker = start("worker", address, "--nthreads", "1", "--no-nanny")
        with monkeypatch.context() as patch:
            patch.setattr("tactiledata.compute.dask.LOOK_AGAIN", 0.2)
            outcomes = SCHEDULERS["dask"](address).outcomes(time.sleep, [0.0] + [60.0] * 40)
            assert next(outcomes).is_ok
            patch.setattr("tactiledata.compute.dask.WORKER_TIMEOUT", 0.5)
            worker.kill()
            with pytest.raises(TactileDataError, match=r"has lost all its workers at 60\.0; .*Start new ones"):
                list(outcomes)
        worker = start("worker", address, "--nthreads", "1", "--no-nanny")
        done = [tmp_path / str(number) for number in range(3)]
        with monkeypatch.context() as patch:
            patch.setattr("tactiledata.compute.dask.LOOK_AGAIN", 0.2)
            outcomes = SCHEDULERS["dask"](address).outcomes(Path.touch, done, 2)
            assert next(outcomes).is_ok
            end = time.monotonic() + 60.0
            while not done[1].exists():
                assert time.monotonic() < end
                time.sleep(0.01)
            time.sleep(1.0)  # the scheduler is told that it is done
            patch.setattr("tactiledata.compute.dask.WORKER_TIMEOUT", 0.5)
            worker.kill()
            with pytest.raises(TactileDataError, match="has lost all its workers at"):
                list(outcomes)
        start("worker", address, "--nthreads", "1", "--no-nanny")
        # a function that a worker finds without the folder of this test
        outcomes = SCHEDULERS["dask"](address).outcomes(time.sleep, [0.2] * 40)
        assert next(outcomes).is_ok
        scheduler.kill()
        with pytest.raises(TactileDataError, match="was lost at"):
            list(outcomes)
    finally:
        for process in started:
            process.kill()
            process.communicate()
