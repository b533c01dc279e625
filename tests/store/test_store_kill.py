"""A writer may be killed at any moment: what was committed stays, and a resumed run ends like an uninterrupted one."""

from __future__ import annotations

import hashlib
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, staged_take

from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store
from tactiledata.store.write import commit as committing
from tactiledata.store.write.commit import commit_groups, create, recover
from tactiledata.store.write.writer import find_staged

pytestmark = pytest.mark.slow

SEEDS = list(range(4))
MOMENTS = ("pwrite", "replace", "rename", "fsync", "ftruncate", "unlink", "rmdir", "open")


@pytest.fixture(autouse=True)
def _small_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(committing, "GROUP_TAKES", 2)


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store without commits, with takes that wait."""
    folder = tmp_path_factory.mktemp("kill") / "staged"
    create(folder, SMALL)
    for seed in SEEDS:
        staged_take(folder, seed)
    return folder


def digest(seed: int) -> str:
    return hashlib.sha256(f"source {seed}".encode()).hexdigest()


def ingest(folder: Path) -> None:
    """What an ingest does when it starts, and starts again: recover, stage what is missing, commit in order."""
    recover(folder)
    known = set(Store.open(folder).manifest["sources"])
    waiting = find_staged(folder)
    takes = [waiting.get(digest(seed)) or staged_take(folder, seed)[0] for seed in SEEDS if digest(seed) not in known]
    commit_groups(folder, takes)


def files(folder: Path) -> dict[str, str]:
    """Digest of every file of a store but its lock."""
    return {
        str(place.relative_to(folder)): hashlib.sha256(place.read_bytes()).hexdigest()
        for place in sorted(folder.rglob("*"))
        if place.is_file() and place.name != ".lock"
    }


@pytest.fixture(scope="module")
def uninterrupted(staged: Path) -> dict[str, str]:
    """The files of a store that was written without interruption."""
    folder = staged.with_name("uninterrupted")
    copy_tree(staged, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(committing, "GROUP_TAKES", 2)
        ingest(folder)
    return files(folder)


def in_child(work: Callable[[], None]) -> int:
    """Runs work in a forked process; its wait status."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    return os.waitpid(child, 0)[1]


def killed_at(folder: Path, moment: int) -> int:
    """Ingest in a process that ends by SIGKILL at the n-th call that changes the disk; its wait status."""

    def work() -> None:
        left = moment

        def counted(call: Callable) -> Callable:
            def run(*arguments, **options):
                nonlocal left
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)
                return call(*arguments, **options)

            return run

        for name in MOMENTS:
            setattr(os, name, counted(getattr(os, name)))
        ingest(folder)

    return in_child(work)


@pytest.mark.parametrize("seed", range(4))
def test_killed_and_resumed_is_the_same(staged: Path, uninterrupted: dict[str, str], seed: int, tmp_path: Path) -> None:
    """A commit killed at random moments and resumed leaves every file as the uninterrupted one does, byte for byte."""
    rng = np.random.default_rng(seed)
    folder = tmp_path / "ds.zarr"
    copy_tree(staged, folder)
    kills = 0
    for _ in range(6):
        kills += os.WIFSIGNALED(killed_at(folder, int(rng.integers(1, 160))))
        store = Store.open(folder)
        assert [found.code for found in check(store) if found.severity != "info"] == []
        assert store.sources()["key"].to_pylist() == [f"run{number}" for number in SEEDS][: store.sources().num_rows]
    assert kills >= 2
    ingest(folder)
    assert files(folder) == uninterrupted


@pytest.mark.parametrize("seed", range(3))
def test_killed_from_outside(staged: Path, uninterrupted: dict[str, str], seed: int, tmp_path: Path) -> None:
    """A kill -9 from another process after a random time leaves a sound store, too."""
    folder = tmp_path / "ds.zarr"
    copy_tree(staged, folder)
    child = os.fork()
    if child == 0:
        ingest(folder)
        os._exit(0)
    time.sleep(float(np.random.default_rng(seed).uniform(0.02, 0.4)))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    ingest(folder)
    assert files(folder) == uninterrupted


def test_control_uncommitted_work_is_seen(staged: Path, uninterrupted: dict[str, str], tmp_path: Path) -> None:
    """The comparison would notice: a store with one take less has other files."""
    folder = tmp_path / "ds.zarr"
    copy_tree(staged, folder)
    commit_groups(folder, [find_staged(folder)[digest(seed)] for seed in SEEDS[:-1]])
    assert files(folder) != uninterrupted


def test_another_order_after_a_kill_leaves_no_trace(staged: Path, tmp_path: Path) -> None:
    """After a killed commit, other takes are committed: nothing of the killed ones stays, beyond lengths included."""
    folder, clean = tmp_path / "ds.zarr", tmp_path / "clean.zarr"
    for place in (folder, clean):
        copy_tree(staged, place)
        commit_groups(place, [find_staged(place)[digest(0)]])
    for moment in (40, 90, 140):
        killed_at(folder, moment)
        if Store.open(folder).sources().num_rows > 1:
            break
    if Store.open(folder).sources().num_rows == 1:
        for place in (folder, clean):
            recover(place)
            commit_groups(place, [find_staged(place)[digest(3)]])
        named = {name: value for name, value in files(folder).items() if ".staging" not in name}
        assert named == {name: value for name, value in files(clean).items() if ".staging" not in name}


def test_readers_see_old_or_new(staged: Path, tmp_path: Path) -> None:
    """While takes are committed, readers see a consistent store: the old one they opened, or a newer one."""
    folder = tmp_path / "ds.zarr"
    copy_tree(staged, folder)
    commit_groups(folder, [find_staged(folder)[digest(seed)] for seed in SEEDS[:2]])
    old = Store.open(folder)
    before = old.encoded(range(old.n_frames))

    def read() -> None:
        for _ in range(15):
            for store in (old, Store.open(folder)):
                assert store.encoded(range(old.n_frames)) == before
                assert store.frames().num_rows == store.n_frames
                assert store.encoded(range(store.n_frames)) is not None
                signal_rows = store.signal("wrench")
                assert len(signal_rows.values(0, signal_rows.n_rows)) == signal_rows.n_rows
        os._exit(7)

    readers = []
    for _ in range(2):
        child = os.fork()
        if child == 0:
            try:
                read()
            finally:
                os._exit(1)
        readers.append(child)
    ingest(folder)
    for child in readers:
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    assert Store.open(folder).n_frames > old.n_frames
    assert old.encoded(range(old.n_frames)) == before
