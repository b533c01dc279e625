"""Every writer under kill -9, on full and read-only disks, and beside another: the same command ends the same."""

import ctypes
import os
import re
import time
from functools import partial

import numpy as np
import pytest
from copied_trees import copy_tree
from failing_writers import files, in_child, is_killed, moments_of, on_a_full_disk
from writers import WRITERS

from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan

pytestmark = pytest.mark.slow

STARTED = re.compile(r"(^|/)\.[^/]+\.(part|old)(/|$)")
"""Hidden files and folders that become others once they are whole."""
COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """A coarse pad, and commits of few recordings."""
    monkeypatch.setitem(structured_pad.PLANS, "low", COARSE)
    monkeypatch.setattr("tactiledata.store.write.commit.GROUP_TAKES", 1)


@pytest.fixture(scope="module")
def prepared(tiny_store, tmp_path_factory):
    """A function that gives a writer's folder as it is before, the files after, and how often it changes the disk."""
    kept = {}

    def make(name):
        if name not in kept:
            base = tmp_path_factory.mktemp(name)
            before, after = base / "before", base / "after"
            before.mkdir()
            if WRITERS[name].tiny:
                copy_tree(tiny_store, before / "ds.zarr")
            WRITERS[name].prepare(before)
            copy_tree(before, after)
            moments = moments_of(partial(run, WRITERS[name], after))
            kept[name] = before, whole(after), moments
        return kept[name]

    return make


def run(writer, folder):
    """Run a writer, in a process of its own; what it keeps for later is among the files that are compared."""
    os.environ["TACTILEDATA_CACHE"] = str(folder / "cache")
    writer.write(folder)


def whole(folder):
    """Digests of the files of a folder, without those that a killed process was still writing, which nobody reads."""
    return {name: digest for name, digest in files(folder).items() if not STARTED.search(name)}


@pytest.fixture
def case(request, prepared, tmp_path):
    """A writer on a fresh folder."""

    class Case:
        writer = WRITERS[request.param]
        before, after, moments = prepared(request.param)
        folder = tmp_path / "case"

        def write(self):
            run(self.writer, self.folder)

        def ends_the_same(self):
            """Whether the same command, left alone, now ends as it would have at once."""
            assert os.waitstatus_to_exitcode(in_child(self.write)) == 0
            assert whole(self.folder) == self.after

    copy_tree(Case.before, Case.folder)
    return Case()


every_writer = pytest.mark.parametrize("case", WRITERS, indirect=True)


@every_writer
def test_killed_it_goes_on(case, request):
    """Killed at two moments of its work, the second time while it goes on, the next run ends as one without a kill."""
    rng = np.random.default_rng(sum(request.node.name.encode()))
    assert is_killed(case.write, int(rng.integers(case.moments // 2)))
    is_killed(case.write, int(rng.integers(case.moments)))
    case.ends_the_same()


@every_writer
def test_on_a_full_disk_it_says_so_and_goes_on(case):
    """A writer whose files cannot grow ends with an error of ours, and goes on once there is room."""
    assert on_a_full_disk(case.write, 20) == 3
    case.ends_the_same()


@every_writer
def test_read_only_it_says_so_and_changes_nothing(case):
    """A writer in a folder that may not be written ends with an error of ours, and leaves every file as it was."""
    before = files(case.folder)
    places = [case.folder, *case.folder.rglob("*")]
    for place in places:
        place.chmod(0o555 if place.is_dir() else 0o444)
    try:
        assert os.waitstatus_to_exitcode(in_child(lambda: (obey_modes(), case.write()))) == 3
        assert files(case.folder) == before
    finally:
        for place in places:
            place.chmod(0o755 if place.is_dir() else 0o644)


@every_writer
def test_two_at_once_end_the_same(case):
    """Two writers at once each end well or say that the other writes; what they leave is what one would have left."""
    children = []
    for _ in range(2):
        child = os.fork()
        if child == 0:
            os._exit(os.waitstatus_to_exitcode(in_child(case.write)))
        children.append(child)
        time.sleep(0.02)
    codes = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
    assert set(codes) <= {0, 3}
    assert 0 in codes
    case.ends_the_same()


def obey_modes():
    """Make the modes of files hold for this process from now on, also where root runs it."""
    library, version, override = ctypes.CDLL(None, use_errno=True), 0x20080522, 0b111
    header, sets = (ctypes.c_uint32 * 2)(version, 0), (ctypes.c_uint32 * 6)()
    assert library.capget(header, sets) == 0
    sets[0] &= ~override
    assert library.capset(header, sets) == 0


def test_control_modes_hold(tmp_path):
    """The read-only tests can fail: a process without the rights of root may not write where the mode forbids it."""
    tmp_path.chmod(0o555)
    place = tmp_path / "new"
    try:
        assert os.waitstatus_to_exitcode(in_child(lambda: (obey_modes(), place.write_text("x")))) == 3
    finally:
        tmp_path.chmod(0o755)
    assert not place.exists()
