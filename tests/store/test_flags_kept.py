"""Flags in a store: killed at any moment, written by two at once, merged, transferred, and after a replacement."""

import multiprocessing
import os
import signal
import time

import pytest
from copied_trees import copy_tree
from random_takes import SMALL, staged_take

from tactiledata.errors import LostFile, StoreError, UsageError
from tactiledata.store.change.flag import carry_flags, flag_trajectories, remove_flags
from tactiledata.store.change.merge import merge
from tactiledata.store.check.flags import flags_findings
from tactiledata.store.layout import flag_file
from tactiledata.store.layout.flag_file import write_flags
from tactiledata.store.layout.places import FLAGS, FLAGS_LOCK
from tactiledata.store.read.flags import flagged_trajectories, stored_flags
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit_groups, create, recover


@pytest.fixture
def place(tiny_store, tmp_path):
    """A copy of the tiny store."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def uids(place):
    return Store.open(place).trajectories(["uid"])["uid"].to_pylist()


def flag_for_ever(place, names):
    """Flag and unflag all trajectories in turn, each time with another reason."""
    turn = 0
    while True:
        flag_trajectories(place, names, f"turn {turn} " + "x" * (turn % 400))
        if turn % 3 == 2:
            remove_flags(place, names)
        turn += 1


def wait_for(is_so, seconds=60.0):
    end = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.002)


@pytest.mark.slow
def test_killed_while_flagging(place):
    """Killed with signal 9 at 25 moments, the file of flags is whole: all trajectories with one reason, or none; the
    next call goes on, and what the killed one was writing is swept away.
    """
    names = uids(place)
    context = multiprocessing.get_context("fork")
    seen = set()
    for attempt in range(25):
        writer = context.Process(target=flag_for_ever, args=(place, names))
        writer.start()
        wait_for((place / FLAGS).exists)
        time.sleep(0.004 + 0.003 * attempt)
        os.kill(writer.pid, signal.SIGKILL)
        writer.join()
        entries = stored_flags(Store.open(place))
        assert set(entries) in (set(names), set())
        reasons = {entry["reason"] for entry in entries.values()}
        assert len(reasons) <= 1
        seen |= reasons
    assert len(seen) > 1  # it was killed at different moments
    flag_trajectories(place, names, "after")
    recover(place)
    assert not [path for path in place.iterdir() if path.name.endswith(".part")]
    assert {entry["reason"] for entry in stored_flags(Store.open(place)).values()} == {"after"}


def test_cut_short_it_is_the_old_file(place, monkeypatch):
    """A writing that fails before renaming leaves the flags that were there; one that does not fail replaces them."""
    names = uids(place)
    flag_trajectories(place, names[:1], "first")
    before = (place / FLAGS).read_bytes()

    def full(path, content):
        raise OSError(28, "No space left on device", str(path))

    with monkeypatch.context() as patch:
        patch.setattr(flag_file, "write_atomic", full)
        with pytest.raises(StoreError, match="No space left"):
            flag_trajectories(place, names, "second")
    assert (place / FLAGS).read_bytes() == before
    assert len(flag_trajectories(place, names, "second")) == len(names)


def test_a_commit_that_sweeps_meanwhile_loses_no_flag(place, monkeypatch):
    """A committing writer removes files that are being written: the flags are written again, and are there."""
    calls = []
    write = flag_file.write_atomic

    def swept_once(path, content):
        calls.append(path)
        if len(calls) == 1:
            raise FileNotFoundError(2, "No such file", str(path))
        write(path, content)

    monkeypatch.setattr(flag_file, "write_atomic", swept_once)
    name = uids(place)[0]
    flag_trajectories(place, [name], "bad")
    assert set(stored_flags(Store.open(place))) == {name}
    assert len(calls) == 2


def add_flag(place, name):
    flag_trajectories(place, [name], f"bad {name}")


@pytest.mark.slow
def test_two_who_flag_at_once_lose_nothing(place):
    """Processes that flag different trajectories at one time: all flags are there afterwards."""
    names = uids(place)
    context = multiprocessing.get_context("fork")
    writers = [context.Process(target=add_flag, args=(place, name)) for name in names]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert set(stored_flags(Store.open(place))) == set(names)


def test_a_store_without_flags_gets_no_file(place):
    """Nothing is written where nothing is flagged; where flags were, none are."""
    write_flags(place, {})
    assert not (place / FLAGS).exists()
    name = uids(place)[0]
    flag_trajectories(place, [name], "bad")
    remove_flags(place, [name])
    assert stored_flags(Store.open(place)) == {}


def test_lost_flags_are_noticed(place):
    """Where flags were written and their file is gone, reading, flagging and check say so; and not where none were."""
    name = uids(place)[0]
    with pytest.raises(UsageError):
        remove_flags(place, [name])
    assert not list(flags_findings(Store.open(place)))
    flag_trajectories(place, [name], "bad")
    remove_flags(place, [name])
    assert not list(flags_findings(Store.open(place)))
    (place / FLAGS).unlink()
    (found,) = flags_findings(Store.open(place))
    assert (found.code, found.severity) == ("store-flags", "damage")
    assert "is gone, and flags were written there" in found.message
    for read in (lambda: flagged_trajectories(Store.open(place)), lambda: flag_trajectories(place, [name], "bad")):
        with pytest.raises(LostFile, match=r"Without one, remove \.flags\.lock"):
            read()
    (place / FLAGS_LOCK).unlink()
    assert flag_trajectories(place, [name], "bad")


def small_store(folder, *seeds):
    create(folder, SMALL)
    commit_groups(folder, [staged_take(folder, seed)[0] for seed in seeds])
    return folder


@pytest.mark.slow
def test_merged_flags_come_along(tmp_path):
    """What is flagged in a source is flagged in the merged store, before its recordings are there; the target's own
    reason stays; merging again is no change.
    """
    one, other = small_store(tmp_path / "a.zarr", 3, 4), small_store(tmp_path / "b.zarr", 4, 5)
    shared = [uid for uid in uids(one) if uid in uids(other)]
    flag_trajectories(one, [uids(one)[0]], "bad in a")
    flag_trajectories(other, [uids(other)[-1]], "bad in b")
    flag_trajectories(one, shared[:1], "first reason")
    flag_trajectories(other, shared[:1], "second reason")
    target = tmp_path / "ab.zarr"
    findings = [finding for finding in merge([one, other], target) if finding.code == "flags-carried"]
    reasons = {uid: flag.reason for uid, flag in flagged_trajectories(Store.open(target)).items()}
    assert reasons[shared[0]] == "first reason"
    assert set(reasons) == set(stored_flags(Store.open(one))) | set(stored_flags(Store.open(other)))
    assert sum(finding.count for finding in findings) == len(reasons) + 1
    before = (target / FLAGS).read_bytes()
    merge([one, other], target)
    assert (target / FLAGS).read_bytes() == before


def test_children_in_another_store_are_flagged_through_their_parent(tmp_path):
    """Flags that are carried for derived trajectories hold for children of flagged parents and grandparents, and for
    no others.
    """
    from unittest.mock import Mock

    import pyarrow as pa

    parents = small_store(tmp_path / "p.zarr", 3)
    grand, parent, free = "g" * 16, "p" * 16, "f" * 16
    entry = {"trajectory": "t", "recording": "r", "reason": "bad", "provenance": {}}
    origin = Mock()
    origin.location = "origin.zarr"
    write_flags(parents, {grand: entry})
    origin.read_file = Store.open(parents).read_file
    table = pa.table(
        {"uid": [grand, parent, free], "parent": ["", grand, ""], "trajectory": ["g", "p", "f"], "source": [0, 0, 0]}
    )
    origin.trajectories = lambda columns: table.select(columns)
    origin.sources = lambda columns: pa.table({"key": ["log"]})
    target = small_store(tmp_path / "c.zarr", 4)
    (finding,) = carry_flags([origin], target, derived=True)
    assert finding.count == 2
    flags = stored_flags(Store.open(target))
    assert set(flags) == {grand, parent}
    assert (flags[parent]["recording"], flags[parent]["trajectory"], flags[parent]["reason"]) == ("log", "p", "bad")
