"""What ends a worker, piece by piece, without starting one."""

import os
import signal
import threading
from multiprocessing import Pipe

import pytest

from tactiledata.contract import worker_pool as module


class Pool:
    """A pool that starts nothing and notes how it was shut down."""

    made = None

    def __init__(self, workers, context, prepare, given):
        self.workers, self.prepare, self.watched = workers, prepare, given[0]
        self.shut = []
        Pool.made = self

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.shut.append("waited")

    def shutdown(self, wait=True, cancel_futures=False):
        # the other end of the pipe is closed by now: a worker that waits for it ends
        self.shut.append((wait, cancel_futures, self.watched.poll(0)))


@pytest.fixture
def pool(monkeypatch):
    monkeypatch.setattr(module, "ProcessPoolExecutor", Pool)


def test_an_error_ends_workers_at_once(pool):
    """The pipe is closed, tasks that wait are dropped, workers are waited for, and the error goes on."""
    block = module.worker_pool(3)
    made = block.__enter__()
    assert made.workers == 3
    assert not made.watched.poll(0)
    stopped = KeyboardInterrupt()
    # it does not swallow the error
    assert not block.__exit__(KeyboardInterrupt, stopped, None)
    assert Pool.made.shut[0] == (True, True, True)


def test_a_block_that_ends_well_waits(pool):
    """Without an error the pool is left as pools are: tasks that were submitted are finished."""
    with module.worker_pool(1) as made:
        pass
    assert made.shut == ["waited"]


def test_a_worker_ends_with_status_one_when_the_pipe_ends(monkeypatch):
    """It waits while the other end is held, ignores interrupts of the terminal, leaves its task, and then ends."""
    ended, handled, left = [], [], []
    monkeypatch.setattr(module, "GRACE_S", 0.0)
    monkeypatch.setattr(module.signal, "pthread_kill", lambda *given: left.append(given))
    monkeypatch.setattr(module.os, "_exit", ended.append)
    monkeypatch.setattr(module.signal, "signal", lambda *given: handled.append(given))
    monkeypatch.setattr(module.signal, "pthread_sigmask", lambda *given: handled.append(given))
    watched, held = Pipe(duplex=False)
    before = set(threading.enumerate())
    with watched:
        module._end_with_parent(watched)
        (thread,) = set(threading.enumerate()) - before
        assert thread.daemon
        thread.join(0.05)
        assert thread.is_alive()
        assert ended == []
        leave = handled[0][1]
        leave(signal.SIGINT, None)
        held.close()
        thread.join(10)
    assert ended == [1]
    # blocked until it is ignored
    assert handled == [(signal.SIGINT, leave), (signal.SIG_UNBLOCK, {signal.SIGINT})]
    assert left == [(threading.get_ident(), signal.SIGINT)]
    with pytest.raises(SystemExit, match="1"):
        leave(signal.SIGINT, None)


@pytest.mark.parametrize("fault", [BrokenPipeError, EOFError])
def test_a_worker_that_can_tell_nobody_ends_without_a_word(monkeypatch, fault):
    """A worker whose parent is gone ends without a traceback; errors of its task are raised as before."""

    def fails(worker):
        raise fault

    monkeypatch.setattr(module.SpawnProcess, "run", fails)
    with pytest.raises(SystemExit, match="1"):
        module.StartedWorker().run()
    fault = ZeroDivisionError
    with pytest.raises(ZeroDivisionError):
        module.StartedWorker().run()


def test_an_interrupt_waits_until_a_worker_has_started(monkeypatch):
    """The start is not cut off, the worker begins with interrupts blocked, and then the interrupt is raised."""
    seen = []

    def start(worker):
        signal.raise_signal(signal.SIGINT)
        seen.append(signal.pthread_sigmask(signal.SIG_BLOCK, ()))

    monkeypatch.setattr(module.SpawnProcess, "start", start)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        worker = module.StartedWorker()
        with pytest.raises(KeyboardInterrupt):
            worker.start()
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    (mask,) = seen
    assert signal.SIGINT in mask
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
    # the processes of a pool, and that of a queue, are started so
    assert module.WorkerContext.Process is module.StartedWorker


def test_a_worker_that_starts_in_peace_starts_no_interrupt(monkeypatch):
    """Negative control: nothing is raised where nothing came, in the main thread and beside it."""
    monkeypatch.setattr(module.SpawnProcess, "start", lambda worker: None)
    module.StartedWorker().start()
    beside = threading.Thread(target=module.StartedWorker().start)
    beside.start()
    beside.join()
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


@pytest.mark.parametrize("told", [None, "default"])
def test_the_tracker_of_a_killed_parent_is_silent_and_nothing_else_is(monkeypatch, told):
    """The variable that silences it is set while it starts, beside what the user set, and then as it was."""
    monkeypatch.delenv(module.WARNINGS, raising=False)
    if told:
        monkeypatch.setenv(module.WARNINGS, told)
    seen = []
    monkeypatch.setattr(module.resource_tracker, "ensure_running", lambda: seen.append(os.environ[module.WARNINGS]))
    module._start_tracker()
    assert seen == ["default,ignore:resource_tracker" if told else "ignore:resource_tracker"]
    assert os.environ.get(module.WARNINGS) == told
