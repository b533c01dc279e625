"""A recording that was corrected takes the place of what a store holds of it, and of nothing else."""

import multiprocessing
import random
import shutil
import time
from contextlib import contextmanager

import pytest
import yaml
from copied_trees import copy_tree
from typer.testing import CliRunner

from tactiledata.cli.main import app
from tactiledata.errors import StoreBusy, StoreError
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.change.flag import flag_trajectories, remove_flags
from tactiledata.store.check.check import check
from tactiledata.store.read.flags import flagged_trajectories, stored_flags
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow

OTHERWISE = IngestOptions(mapping={"format": "tactiledata-mapping/1", "clock": "log"})


def states(report):
    return [source.state for source in report.sources]


def seen(place):
    """All tables and aligned values of a store but where images lie."""
    store = Store.open(place)
    frames = store.frames().drop_columns(["offset"]).to_pylist()
    aligned = [repr(store.aligned(name)) for name in store.aligned_names]
    return [frames, store.trajectories(), store.sources(), store.findings(), aligned, store.digest, store.sensors()]


@pytest.fixture
def wrong(tiny_mcaps, tmp_path):
    """A store whose first recording was taken with another mapping."""
    ingest(tiny_mcaps[:1], tmp_path / "ds.zarr", OTHERWISE)
    ingest(tiny_mcaps[1:], tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def test_a_corrected_mapping_replaces(tiny_mcaps, tiny_store, wrong):
    """The store becomes the one that had the right mapping from the start; a second time changes nothing."""
    assert seen(wrong) != seen(tiny_store)
    report = ingest(tiny_mcaps, wrong, replace=True)
    assert states(report) == ["replaced", "present"]
    assert seen(wrong) == seen(tiny_store)
    assert check(wrong, decode=True) == []
    manifest = (wrong / "manifest.json").read_bytes()
    assert states(ingest(tiny_mcaps, wrong, replace=True)) == ["present", "present"]
    assert (wrong / "manifest.json").read_bytes() == manifest


def test_an_edited_log_replaces_its_recording(tiny_folders, tmp_path):
    """An edited log.yaml has another digest; by name and images it is the recording that it was before."""
    logs = [copy_tree(log, tmp_path / "logs" / log.name) for log in tiny_folders]
    ingest(logs, tmp_path / "ds.zarr")
    for log in logs[:1]:
        described = yaml.safe_load((log / "log.yaml").read_text())
        described["licence"] = "CC0"
        (log / "log.yaml").write_text(yaml.safe_dump(described))
    report = ingest(logs, tmp_path / "ds.zarr", replace=True)
    assert states(report) == ["replaced", "present"]
    ingest(logs, tmp_path / "right.zarr")
    assert seen(tmp_path / "ds.zarr") == seen(tmp_path / "right.zarr")


def test_a_flag_of_what_was_replaced_is_said(tiny_folders, tmp_path):
    """A flag on a recording that an edited one replaces holds for nothing in the store any more, and that is said with
    its reason; a flag on one that stays holds, and is not mentioned (the negative control).
    """
    logs = [copy_tree(log, tmp_path / "logs" / log.name) for log in tiny_folders]
    place = tmp_path / "ds.zarr"
    ingest(logs, place)
    went, stays = (Store.open(place).trajectories(["uid"])["uid"][at].as_py() for at in (0, -1))
    flag_trajectories(place, [went], "slipped")
    flag_trajectories(place, [stays], "torn gel")
    (logs[0] / "log.yaml").write_text((logs[0] / "log.yaml").read_text() + "\n# edited\n")
    report = ingest(logs, place, replace=True)
    (said,) = [finding for finding in report.findings if finding.code == "flag-left"]
    assert (said.severity, "slipped" in said.message) == ("warning", True)
    assert set(flagged_trajectories(Store.open(place))) == {stays}
    assert set(stored_flags(Store.open(place))) == {went, stays}
    assert remove_flags(place, [went])


PICTURE = "reference/D20001/image/c.0.0.0"


@pytest.mark.parametrize("file", ["streams/digit/heap/c.0", "signals/wrench/value/c.0.0", PICTURE])
def test_what_was_damaged_in_the_store_comes_back(tiny_mcaps, tiny_store, tmp_path, file):
    """Images and numbers whose bytes changed on the disk are taken from the recordings again."""
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    content = bytearray((store / file).read_bytes())
    content[40] ^= 0x55
    (store / file).write_bytes(content)
    assert "damage" in {one.severity for one in check(store)}
    assert "replaced" in states(ingest(tiny_mcaps, store, replace=True))
    assert [one.code for one in check(store) if one.severity == "damage"] == []
    assert seen(store) == seen(tiny_store)


def test_a_lost_picture_without_contact_comes_back(tiny_mcaps, tiny_store, tmp_path):
    """It is told as lost, and comes with the recording that brought it; the other recording stays as it is."""
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    (store / PICTURE).unlink()
    (found,) = check(store)
    assert found.message.endswith("is damaged: the file with its pixels is missing")
    assert states(ingest(tiny_mcaps, store, replace=True)) == ["replaced", "present"]
    assert check(store) == []
    assert seen(store) == seen(tiny_store)
    assert (Store.open(store).reference("D20001").image == Store.open(tiny_store).reference("D20001").image).all()


def test_numbers_that_two_recordings_share_come_back_together(tiny_mcaps, tiny_store, tmp_path):
    """A lost file with numbers of both is not mended by one of them, and the message says so; by both it is."""
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    (store / "aligned/contact_wrench/value/c.0.0").unlink()
    for one in tiny_mcaps:
        with pytest.raises(StoreError, match="names in one command, with --replace"):
            ingest([one], store, replace=True)
    assert states(ingest(tiny_mcaps, store, replace=True)) == ["replaced", "replaced"]
    assert check(store) == []


def test_twins_become_one(tiny_folders, tmp_path):
    """Where the edited copy was added as a recording of its own before, one of the two stays."""
    log = copy_tree(tiny_folders[0], tmp_path / "logs" / tiny_folders[0].name)
    ingest([log], tmp_path / "ds.zarr")
    (log / "log.yaml").write_text((log / "log.yaml").read_text() + "\n# edited\n")
    assert states(ingest([log], tmp_path / "ds.zarr")) == ["added"]
    assert states(ingest([log], tmp_path / "ds.zarr", replace=True)) == ["replaced"]
    ingest([log], tmp_path / "right.zarr")
    assert seen(tmp_path / "ds.zarr") == seen(tmp_path / "right.zarr")


def test_a_recording_that_only_has_the_same_name_is_added(tiny_mcaps, tmp_path):
    """Two recordings called alike are two; that nothing was replaced is said (the negative control)."""
    ingest(tiny_mcaps[:1], tmp_path / "ds.zarr")
    other = tmp_path / "other" / tiny_mcaps[0].name
    other.parent.mkdir()
    shutil.copy(tiny_mcaps[1], other)
    report = ingest([other], tmp_path / "ds.zarr", replace=True)
    assert states(report) == ["added"]
    assert "nothing-replaced" in {finding.code for finding in report.sources[0].findings}
    assert Store.open(tmp_path / "ds.zarr").sources().num_rows == 2


def test_the_summary_says_which_splits_have_to_be_drawn_anew(tiny_mcaps, tiny_store, tmp_path):
    """The command says what was replaced; a split is out of date where touches came or went, and only there."""
    store = tmp_path / "ds.zarr"
    copy_tree(tiny_store, store)
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("format: tactiledata-mapping/1\nclock: log\n")
    words = ["ingest", str(tiny_mcaps[0]), "--store", str(store), "--mapping", str(mapping)]
    assert "--replace" in CliRunner().invoke(app, words).output
    said = CliRunner().invoke(app, [*words, "--replace"]).output
    assert "1 replaced" in said
    assert "out of date" not in said
    assert f"next: tactiledata audit {store} --split default" in said.replace("\n", "")
    copied = tmp_path / "more.mcap"
    copied.write_bytes(tiny_mcaps[0].read_bytes() + b"x")
    said = CliRunner().invoke(app, ["ingest", str(copied), "--store", str(store)]).output
    assert "the split default is out of date" in said


def test_a_replaced_recording_is_said_to_be_drawn_anew(tiny_folders, tmp_path):
    """An edited log is another recording for a split, which is said; where nothing was split, it is not."""
    logs = [copy_tree(log, tmp_path / "logs" / log.name) for log in tiny_folders]
    store = str(tmp_path / "ds.zarr")
    ingest(logs, store)
    for is_split in (False, True):
        if is_split:
            CliRunner().invoke(app, ["split", store, "--hold-out", "none", "--force", "none"])
        with (logs[0] / "log.yaml").open("a") as stream:
            stream.write("\n# edited\n")
        said = CliRunner().invoke(app, ["ingest", str(logs[0]), "--store", store, "--replace"]).output
        assert ("may come into another part" in said) == is_split


def test_a_staged_take_of_another_mapping_is_read_again(tiny_mcaps, tiny_store, tmp_path, monkeypatch):
    """What a killed ingest staged with another mapping is not taken for what was asked for now."""
    store = tmp_path / "ds.zarr"

    def killed(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("tactiledata.store.write.commit.commit", killed)
    with pytest.raises(KeyboardInterrupt):
        ingest(tiny_mcaps, store, OTHERWISE)
    monkeypatch.undo()
    assert list((store / ".staging").glob("*/take.json"))
    ingest(tiny_mcaps, store)
    assert seen(store) == seen(tiny_store)


def test_a_first_ingest_that_fails_leaves_no_store(tmp_path):
    """Where nothing could be read there is no store afterwards; an empty folder of the user's stays one."""
    (tmp_path / "run.mcap").write_bytes(b"\x89MCAP0\r\n" + b"no records" * 10)
    (tmp_path / "mine").mkdir()
    for store in (tmp_path / "ds.zarr", tmp_path / "mine"):
        assert states(ingest([tmp_path / "run.mcap"], store)) == ["failed"]
    assert not (tmp_path / "ds.zarr").exists()
    assert list((tmp_path / "mine").iterdir()) == []


def test_whoever_is_turned_away_leaves_the_store_alone(tiny_mcaps, tmp_path, monkeypatch):
    """Of two first ingests into one store, the one that finds it busy does not take the other's new store away."""
    store = tmp_path / "ds.zarr"

    @contextmanager
    def busy(*_):
        raise StoreBusy("the store is being written by process 1", "no other writer")
        yield

    with monkeypatch.context() as patch:
        patch.setattr("tactiledata.store.write.intake.writing_lock", busy)
        with pytest.raises(StoreBusy):
            ingest(tiny_mcaps, store)
    assert (store / "manifest.json").exists()


def test_copies_of_a_recording_among_several_workers(tiny_mcaps, tiny_store, tmp_path):
    """Two workers that are given the same bytes under other names end with one recording, and no error."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    for number in range(3):
        shutil.copy(tiny_mcaps[0], folder / f"copy{number}.mcap")
    report = ingest([folder], tmp_path / "ds.zarr", workers=2)
    assert states(report) == ["added", "present", "present"]
    assert check(tmp_path / "ds.zarr") == []


def test_killed_while_replacing(tiny_mcaps, tiny_store, wrong, tmp_path):
    """Kill -9 at random moments: the store is whole each time, and the same call ends with the corrected store."""
    clock = random.Random(3)
    # a process that has imported the toolkit once makes those that are killed
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([ingest.__module__])
    started = time.monotonic()
    ingest(tiny_mcaps, copy_tree(wrong, tmp_path / "timed.zarr"), replace=True)
    span = time.monotonic() - started
    kills = 0
    for trial in range(4):
        store = copy_tree(wrong, tmp_path / f"{trial}.zarr")
        for _ in range(2):
            process = context.Process(target=ingest, args=(tiny_mcaps, store), kwargs={"replace": True})
            process.start()
            process.join(clock.uniform(0, 1.1 * span))
            kills += process.exitcode is None
            process.kill()
            process.join()
            process.close()
            assert [one.code for one in check(store) if one.severity != "info"] == []
        ingest(tiny_mcaps, store, replace=True)
        assert seen(store) == seen(tiny_store)
        assert check(store) == []
    assert kills >= 4
