"""Recordings become a store: whole, once, the same whoever does the work and whenever it is killed."""

import json
import multiprocessing
import os
import random
import shutil
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from copied_trees import copy_tree

from tactiledata.errors import BrokenLog, MissingFile, SchemaError, StoreBusy
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.check.check import check
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.places import INTAKE_LOCK
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import create


def manifest(store):
    return (store / "manifest.json").read_bytes()


@pytest.mark.slow
def test_the_truth_comes_back(tiny_mcaps, tiny_store):
    """Every trajectory's contact wrench in the gel frame equals the rig's truth within the sensor's noise."""
    store = Store.open(tiny_store)
    keys = store.sources(["key"])["key"].to_pylist()
    contact = store.signal("contact_wrench")
    rows = store.trajectories().to_pylist()
    assert len(rows) == 4
    for row in rows:
        name = keys[row["source"]].removesuffix(".mcap")
        truth = pq.read_table(tiny_mcaps[0].parent / "truth" / f"{name}.parquet").to_pandas()
        truth = truth[truth["stream"] == "wrench"]
        start, stop = json.loads(row["signal_rows"])["contact_wrench"]
        origin = truth["host_ns"].iloc[0]
        expected = np.stack(
            [
                np.interp(contact.t_ns(start, stop) - origin, truth["host_ns"] - origin, truth[axis])
                for axis in ("fx", "fy", "fz")
            ],
            axis=1,
        )
        error = contact.values(start, stop)[:, :3] - expected
        assert np.abs(error.mean(axis=0)).max() < 0.15
        assert error.std(axis=0).max() < 0.2
        assert expected[:, 2].max() > 0.5


@pytest.mark.slow
def test_both_forms_of_a_log_give_one_dataset(tiny_store, tiny_folders, tmp_path):
    """MCAP and folder log of one world give the same trajectories, and the same pictures to the bit."""
    ingest(tiny_folders, tmp_path / "folder.zarr")
    one, other = Store.open(tiny_store), Store.open(tmp_path / "folder.zarr")
    columns = ["trajectory", "sensor", "indenter", "frame_start", "frame_stop"]
    assert one.trajectories(columns).to_pylist() == other.trajectories(columns).to_pylist()
    assert one.frames(["crc32c"]) == other.frames(["crc32c"])


def test_the_same_source_twice_is_no_change(tiny_mcaps, tiny_store, tmp_path):
    """Ingesting again changes nothing, nor does a renamed copy of a file that the store has."""
    store = tmp_path / "ds.zarr"
    copy_tree(tiny_store, store)
    copy = shutil.copy(tiny_mcaps[0], tmp_path / "renamed.mcap")
    before = manifest(store)
    report = ingest([*tiny_mcaps, copy], store)
    assert [source.state for source in report.sources] == ["present"] * 3
    assert manifest(store) == before


def test_another_mapping_for_a_recording_that_is_there_is_said(tiny_mcaps, tiny_store, tmp_path):
    """Nothing changes, and the report says that the store took it otherwise; with the same options it says nothing."""
    store = tmp_path / "ds.zarr"
    copy_tree(tiny_store, store)
    mapping = {"format": "tactiledata-mapping/1", "clock": "log"}
    codes = [
        finding.code for finding in ingest(tiny_mcaps[:1], store, IngestOptions(mapping=mapping)).sources[0].findings
    ]
    assert codes == ["ingested-otherwise"]
    assert ingest(tiny_mcaps[:1], store).sources[0].findings == ()
    assert manifest(store) == manifest(tiny_store)


@pytest.mark.slow
def test_appending_equals_ingesting_at_once(tiny_mcaps, tiny_store, tmp_path):
    """One source after the other gives the rows that both at once give."""
    for log in tiny_mcaps:
        ingest([log], tmp_path / "ds.zarr")
    one, other = Store.open(tiny_store), Store.open(tmp_path / "ds.zarr")
    assert one.digest == other.digest
    assert one.trajectories() == other.trajectories()
    assert one.frames() == other.frames()


@pytest.mark.slow
def test_workers_change_nothing(tiny_mcaps, tiny_store, tmp_path, monkeypatch):
    """Two processes write the manifest that one writes, byte for byte; a real Dask cluster does, too.

    Relative paths are those of the caller: the cluster's workers were started in another folder.
    """
    ingest(tiny_mcaps, tmp_path / "two.zarr", workers=2)
    assert manifest(tmp_path / "two.zarr") == manifest(tiny_store)
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        monkeypatch.chdir(tiny_mcaps[0].parent)
        ingest([log.name for log in tiny_mcaps], tmp_path / "dask.zarr", scheduler=cluster.scheduler_address)
    assert manifest(tmp_path / "dask.zarr") == manifest(tiny_store)


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on(tiny_mcaps, tiny_store, tmp_path):
    """An ingest that is killed at random moments and resumed gives the manifest of an uninterrupted one."""
    clock = random.Random(20)
    # a process that has imported the toolkit once makes those that are killed
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([ingest.__module__])
    started = time.monotonic()
    ingest(tiny_mcaps, tmp_path / "timed.zarr")
    span = time.monotonic() - started
    kills = 0
    for trial in range(40):
        if kills >= 20:
            break
        store = tmp_path / f"{trial}.zarr"
        for _ in range(3):
            process = context.Process(target=ingest, args=(tiny_mcaps, store))
            process.start()
            process.join(clock.uniform(0, 1.1 * span))
            kills += process.exitcode is None
            process.kill()
            process.join()
            process.close()
        ingest(tiny_mcaps, store)
        assert manifest(store) == manifest(tiny_store)
        assert check(store) == []
        uids = Store.open(store).trajectories(["uid"])["uid"].to_pylist()
        assert len(uids) == len(set(uids)) == 4
    assert kills >= 20


@pytest.mark.slow
def test_two_ingests_do_not_sweep_away_each_other(tiny_mcaps, tmp_path):
    """While one ingest stages takes, another is turned away with the process to wait for."""
    store = tmp_path / "ds.zarr"
    create(store)
    with writing_lock(store, INTAKE_LOCK), pytest.raises(StoreBusy, match=str(os.getpid())):
        ingest(tiny_mcaps, store)
    assert ingest(tiny_mcaps, store).sources[0].state == "added"


@pytest.mark.slow
def test_a_damaged_recording_is_kept_as_far_as_it_goes(tiny_mcaps, tmp_path):
    """A file cut at 60 % gives what is whole, says what was lost, and the other recording comes in untouched."""
    cut = tmp_path / "cut.mcap"
    content = tiny_mcaps[0].read_bytes()
    cut.write_bytes(content[: int(0.6 * len(content))])
    report = ingest([cut, tiny_mcaps[1]], tmp_path / "ds.zarr")
    assert report.fell_short
    assert [source.status for source in report.sources] == ["damaged", "ok"]
    assert 0 < report.sources[0].frames < 28
    codes = {finding.code for finding in report.sources[0].findings}
    assert "trajectory-incomplete" in codes
    stored = Store.open(tmp_path / "ds.zarr").findings()
    assert {"damage"} <= set(stored["severity"].to_pylist())


@pytest.mark.slow
def test_strict_refuses_damage_and_takes_the_rest(tiny_mcaps, tmp_path):
    """With strict, the damaged recording is not in the store, and the report says why."""
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(tiny_mcaps[0].read_bytes()[:-100])
    report = ingest([cut, tiny_mcaps[1]], tmp_path / "ds.zarr", IngestOptions(strict=True))
    assert [source.state for source in report.sources] == ["failed", "added"]
    assert "--strict" in report.sources[0].error
    assert Store.open(tmp_path / "ds.zarr").sources(["key"])["key"].to_pylist() == [tiny_mcaps[1].name]


def test_nothing_to_ingest_is_an_error(tmp_path):
    """A path that is not there, a folder without recordings and a mapping that does not fit are refused before work."""
    with pytest.raises(MissingFile, match="does not exist"):
        ingest([tmp_path / "nowhere"], tmp_path / "ds.zarr")
    (tmp_path / "empty").mkdir()
    with pytest.raises(BrokenLog, match="holds no recording and no file"):
        ingest([tmp_path / "empty"], tmp_path / "ds.zarr")
    bad = {"format": "tactiledata-mapping/1", "signals": {"Wrench!": {"topic": "/w"}}}
    with pytest.raises(SchemaError, match=r"\$\.signals"):
        ingest([tmp_path], tmp_path / "ds.zarr", IngestOptions(mapping=bad))
    assert not (tmp_path / "ds.zarr").exists()
