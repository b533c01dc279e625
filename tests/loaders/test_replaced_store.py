"""A dataset that outlives a change of its store gives the same items as before, or says that it cannot."""

import pickle
import shutil

import numpy as np
import pytest
from copied_trees import copy_tree

from tactiledata.errors import StoreError
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store

STREAMS = ["digit", "contact_wrench"]


@pytest.fixture
def place(tiny_mcaps, tmp_path):
    """A store of one recording, with a split."""
    ingest(tiny_mcaps[:1], tmp_path / "ds.zarr")
    make_split(Store.open(tmp_path / "ds.zarr"), by="trajectory", hold_out="none", force=None)
    return tmp_path / "ds.zarr"


@pytest.mark.slow
def test_another_process_after_an_append_reads_the_same(place, tiny_mcaps):
    """What was appended meanwhile does not disturb (the negative control)."""
    dataset = TactileArrays(place, split="default/train", streams=STREAMS)
    before = dataset[0]["contact_wrench"]
    ingest(tiny_mcaps[1:], place)
    assert np.array_equal(pickle.loads(pickle.dumps(dataset))[0]["contact_wrench"], before)


@pytest.mark.slow
def test_another_process_after_a_replacement_says_so(place, tiny_mcaps, tmp_path):
    """Rows mean something else then, in the replaced store and in another one put in its place: an error, no items."""
    dataset = TactileArrays(place, split="default/train", streams=STREAMS)
    aside = copy_tree(place, tmp_path / "aside.zarr")
    ingest(tiny_mcaps[:1], place, IngestOptions(gap_limit_ns=1), replace=True)
    with pytest.raises(StoreError, match="was replaced since"):
        pickle.loads(pickle.dumps(dataset))[0]
    shutil.rmtree(place)
    ingest(tiny_mcaps[1:], place)
    with pytest.raises(StoreError, match="was replaced since"):
        pickle.loads(pickle.dumps(dataset))[0]
    shutil.rmtree(place)
    aside.rename(place)
    pickle.loads(pickle.dumps(dataset))[0]
