"""The fuzzer finds what it looks for, and a short run of it over every reader finds nothing."""

import os
import signal
import tempfile
import threading
import time

import numpy as np
import pytest
from fuzz_mutations import mutate_bytes, mutate_folder
from fuzz_readers import READERS, Reader
from run_fuzz import GIB, Limits, _wants_to_run, fuzz, run_cases

from tactiledata.errors import BrokenLog


def plain(folder):
    """A file of text."""
    (folder / "numbers.csv").write_text("a,b\n1,2\n", encoding="utf-8")


def refuse(folder):
    raise BrokenLog("a file", "another one")


def wait(folder):
    time.sleep(60)


def turn(folder):
    while True:
        pass


def fill(folder):
    return np.ones(GIB, np.uint8)


def end(folder):
    os.kill(os.getpid(), signal.SIGSEGV)


@pytest.mark.parametrize(
    ("read", "what"),
    [
        (lambda folder: int("x"), "ValueError"),
        (fill, "MemoryError"),
        (wait, "more than 0.3 s"),
        (turn, "more than 0.3 s"),
        (end, "the process ended: -11"),
        (refuse, None),
    ],
    ids=["traceback", "memory", "wait", "endless", "crash", "own-error"],
)
def test_each_kind_of_fault_is_found_and_kept(read, what, tmp_path):
    """A traceback, a crash, a hang and too much memory are faults, each with its files; an error of ours is none."""
    plain(tmp_path)
    whole = tmp_path / "whole"
    whole.mkdir()
    plain(whole)
    reader = Reader("mine", plain, read)
    found = run_cases(reader, whole, range(2), Limits(0.3, GIB // 2), tmp_path / "kept")
    assert [fault.what.startswith(what or "") for fault in found] == ([True, True] if what else [])
    assert {place.name for place in (tmp_path / "kept").glob("*")} == ({"mine-0", "mine-1"} if what else set())


def test_a_thread_at_work_is_no_wait():
    """A process whose main thread waits for another one wants to run; one that sleeps does not."""

    def work_in_thread():
        thread = threading.Thread(target=turn, args=(None,))
        thread.start()
        thread.join()

    for work, wants in ((work_in_thread, True), (lambda: wait(None), False)):
        child = os.fork()
        if child == 0:
            work()
        try:
            time.sleep(0.2)
            assert _wants_to_run(child) is wants
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


def test_changes_are_drawn_by_their_seed(tmp_path):
    """The same seed gives the same bytes, another seed others; a change changes."""
    content = bytes(range(256)) * 4
    drawn = [mutate_bytes(content, np.random.default_rng(seed)) for seed in (1, 1, 2, 3, 4)]
    assert drawn[0] == drawn[1]
    assert len({*drawn, content}) == 5
    for seed in range(5):
        plain(tmp_path)
        before = (tmp_path / "numbers.csv").read_bytes()
        said = mutate_folder(tmp_path, np.random.default_rng([seed, 3]))
        assert said.startswith("numbers.csv: ")
        assert not (tmp_path / "numbers.csv").exists() or (tmp_path / "numbers.csv").read_bytes() != before, said


SMOKE = ("folder", "across_hdf5", "mapping", "scenario", "table", "mesh", "pad", "picture", "effects", "proof")
"""One reader of each kind of bytes, of those that take little time."""


@pytest.mark.slow
def test_a_short_run_finds_nothing(monkeypatch, tmp_path):
    """Two changed sets of files for each kind of bytes end in results or errors of ours, and whole ones are read."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    turns = list(fuzz([READERS[name] for name in SMOKE], 0, 7, Limits(), tmp_path / "kept", cases=2))
    assert [name for name, _, _ in turns] == list(SMOKE)
    assert [fault for _, _, found in turns for fault in found] == []
