"""A chunk that was deleted is no chunk in which nothing was recorded."""

import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, random_take

from tactiledata.contract.take import AlignedSignal
from tactiledata.errors import StoreError
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import stage, staging_folder


@pytest.fixture
def copy(tiny_store, tmp_path):
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def lose_chunk(store, array):
    """Delete the first chunk file of an array."""
    min(path for path in (store / array).iterdir() if path.name.startswith("c")).unlink()


def test_aligned_values_of_a_lost_chunk_are_refused(copy):
    """They would read as frames without force."""
    lose_chunk(copy, "aligned/contact_wrench/value")
    store = Store.open(copy)
    with pytest.raises(StoreError, match=r"a chunk of array aligned/contact_wrench/value .* is missing: rows 0 to"):
        store.aligned("contact_wrench")


@pytest.mark.parametrize("array", ["value", "t_ns"])
def test_readings_of_a_lost_chunk_are_refused(copy, array):
    """Values would read as no numbers, and times as 0."""
    lose_chunk(copy, f"signals/contact_wrench/{array}")
    signal = Store.open(copy).signal("contact_wrench")
    with pytest.raises(StoreError, match=f"signals/contact_wrench/{array} .* is missing"):
        signal.values(0, 4) if array == "value" else signal.t_ns(0, 4)


def test_rows_in_which_nothing_was_recorded_are_read(tmp_path):
    """Zarr writes no file for a chunk of fill: frames without force, and readings without a header's time."""
    path = tmp_path / "ds.zarr"
    create(path, SMALL)
    sha256 = "0" * 64
    spool = Spool(staging_folder(path, sha256))
    take = random_take(3, spool, n_frames=12)
    nothing = np.full((12, 2), np.nan)
    gaps = np.full(12, -1, dtype=np.int64)
    take.aligned["wrench"] = AlignedSignal(nothing, gaps, ("fx", "fz"), ("N", "N"), "ft", "linear")
    commit(path, [stage(path, spool, take)])
    store = Store.open(path)
    assert not list((path / "aligned" / "wrench" / "value").glob("c*"))
    values, _ = store.aligned("wrench")
    assert np.isnan(values).all()
    signal = store.signal("wrench")
    assert (signal.stamps("header", 0, signal.n_rows) == -1).all()
