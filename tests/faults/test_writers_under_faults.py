"""Every writer under kill -9, on full and read-only disks, and beside another: the same command ends the same."""

import os
import re
import time
from functools import partial

import numpy as np
import pytest
from copied_trees import copy_tree
from failing_writers import begun, ended, files, fill_disk, is_killed, moments_of, obey_modes, read_only
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
            kept[name] = before, (WRITERS[name].same or whole)(after), moments
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
            assert ended(self.write) == (0, {})
            assert (self.writer.same or whole)(self.folder) == self.after

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
    """A writer whose files cannot grow says so, with exit code 1, harms nothing, and goes on once there is room."""
    before = files(case.folder)
    code, said = ended(lambda: (fill_disk(20), case.write()))
    assert (code, "File too large" in said["error"]) == (1, True), said
    assert before.items() <= files(case.folder).items()
    case.ends_the_same()


@every_writer
def test_read_only_it_says_so_and_changes_nothing(case):
    """A writer in a folder that may not be written says so, with exit code 1, and leaves every file as it was."""
    before = files(case.folder)
    with read_only(case.folder):
        code, said = ended(lambda: (obey_modes(), case.write()))
        assert (code, "Permission denied" in said["error"]) == (1, True), said
        assert files(case.folder) == before


@every_writer
def test_two_at_once_end_the_same(case):
    """Two processes that write at once leave what one leaves; one that cannot finish names the other in its error."""
    waits = []
    for _ in range(2):
        waits.append(begun(case.write))
        time.sleep(0.02)
    ends = [wait() for wait in waits]
    assert (0, {}) in ends
    assert all(code == 0 or (code == 1 and "process" in said["error"]) for code, said in ends), ends
    case.ends_the_same()


def test_control_modes_hold(tmp_path):
    """The read-only tests can fail: a process without the rights of root may not write where the mode forbids it."""
    place = tmp_path / "new"
    with read_only(tmp_path):
        code, said = ended(lambda: (obey_modes(), place.write_text("x")))
    assert (code, "Permission denied" in said["error"]) == (1, True)
    assert not place.exists()
