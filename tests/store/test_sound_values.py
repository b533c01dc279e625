"""Whoever computes from a store's numbers asks first whether they are those of its sources."""

from pathlib import Path

import pytest
from copied_trees import copy_tree

from tactiledata.calibrate.measured import read_measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.store import diagnose_store
from tactiledata.errors import TactileDataError
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.read.reader import Store


@pytest.fixture
def copy(tiny_store, tmp_path):
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def chunk_of(store, array):
    return min(path for path in (store / array).iterdir() if path.name.startswith("c"))


def test_a_whole_store_is_sound(tiny_store):
    """A store as it was written has sound values in all of its signals."""
    store = Store.open(tiny_store)
    need_sound_values(store, store.signal_names)


@pytest.mark.parametrize("array", ["aligned/contact_wrench/value", "signals/contact_wrench/value"])
def test_a_lost_chunk_is_no_recording_without_forces(copy, array):
    """It reads as numbers that nobody recorded; calibration and diagnosis, which read touches alike, say so."""
    chunk_of(copy, array).unlink()
    with pytest.raises(
        TactileDataError, match=rf"a damaged store: {array}, rows 0 to \d+ of .*mcap: the file {array}/c.0.0 is missing"
    ):
        read_measured(OpenedStore.planned(Store.open(copy), CalibrationOptions().pads), CalibrationOptions())


@pytest.mark.parametrize("array", ["signals/tcp/value", "signals/wrench/value", "signals/joints/t_ns"])
@pytest.mark.parametrize("damage", [Path.unlink, lambda chunk: chunk.write_bytes(chunk.read_bytes()[:100])])
def test_a_diagnosis_asks_for_all_that_it_reads_before_it_plays(copy, array, damage):
    """The force sensor's zero is told by readings and poses at their native rate: none of them is left out unsaid."""
    damage(chunk_of(copy, array))
    with pytest.raises(TactileDataError, match=f"a damaged store: {array}, rows"):
        diagnose_store(Store.open(copy), DiagnosisOptions())


def test_what_is_not_asked_for_may_be_lost(copy):
    """Forces do not need poses at their native rate."""
    chunk_of(copy, "signals/tcp/value").unlink()
    need_sound_values(Store.open(copy), ["contact_wrench"])
    with pytest.raises(TactileDataError, match="tcp"):
        need_sound_values(Store.open(copy), ["tcp"])
