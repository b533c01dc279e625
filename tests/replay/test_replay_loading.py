"""Meshes as streams of a dataset."""

import numpy as np
import pytest
from coarse import options
from copied_trees import copy_tree

from tactiledata.errors import UnknownName, UsageError
from tactiledata.loaders.missing import MissingValuesWarning
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.replay.attach import replay
from tactiledata.store.read.reader import Store

STREAMS = ["digit", "contact_wrench", "mesh", "mesh_wrench", "contact_mask"]


@pytest.mark.slow
def test_items_are_the_rows_of_the_mesh(replayed):
    """Items hold the mesh's rows of their frames, one by one and as a whole trajectory."""
    mesh = Store.open(replayed).mesh("coarse")
    data = TactileArrays(replayed, "default/train", STREAMS, missing="keep")
    batch = data.batch(range(len(data)))
    assert np.array_equal(batch["mesh"], mesh.displacement(batch["frame"]))
    assert np.array_equal(batch["mesh_wrench"], mesh.wrench(batch["frame"]).astype(np.float32))
    assert np.array_equal(batch["contact_mask"], mesh.contact(batch["frame"]))
    assert (batch["mesh"].dtype, batch["contact_mask"].dtype) == (np.float32, np.bool_)
    whole = TactileArrays(replayed, "default/train", STREAMS, "trajectory", missing="keep")[0]
    assert np.array_equal(whole["mesh"], mesh.displacement(whole["frame"]))


def test_tensors_and_batches_of_trajectories(replayed):
    """PyTorch gets tensors of the same shape, and batches of trajectories padded by frames."""
    torch = pytest.importorskip("torch")
    from tactiledata.loaders.torch import TactileDataset, collate

    frames = TactileDataset(replayed, "default/train", ["digit", "wrench", "mesh"], missing="keep")
    sizes = frames.arrays.store.mesh("coarse").facts["sizes"]
    assert frames[0]["mesh"].shape == (sizes["kept"], 3)
    touches = TactileDataset(replayed, "default/train", ["mesh", "contact_mask"], "trajectory", missing="keep")
    batch = collate([touches[0], touches[len(touches) - 1]])
    assert batch["mesh"].shape[:2] == batch["frames_mask"].shape
    assert batch["contact_mask"].dtype == torch.bool


@pytest.mark.slow
def test_of_several_meshes_one_must_be_named(replayed, tmp_path):
    """An error that says how; with the name it is that one."""
    place = tmp_path / "ds.zarr"
    copy_tree(replayed, place)
    replay(place, options(name="surface", keep="surface"))
    with pytest.raises(UsageError, match="mesh/coarse"):
        TactileArrays(place, "default/train", ["mesh"])
    with pytest.raises(UnknownName, match="surface"):
        TactileArrays(place, "default/train", ["mesh/fine"])
    data = TactileArrays(place, "default/train", ["mesh/coarse", "mesh/surface"], missing="keep")
    sizes = data.store.mesh("surface").facts["sizes"]
    assert data[0]["mesh/surface"].shape == (sizes["surface"], 3)
    assert data[0]["mesh/coarse"].shape == (sizes["vertices"], 3)


@pytest.mark.slow
def test_frames_without_a_mesh_are_counted_and_dropped(tiny_mcaps, tmp_path):
    """Those that were not replayed yet are NaN with a warning, or no items."""
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.splits.make import make_split

    place = tmp_path / "ds.zarr"
    ingest(tiny_mcaps[:1], place)
    replayed_frames = replay(place, options()).new_frames
    ingest(tiny_mcaps[1:], place)
    make_split(Store.open(place), hold_out="none")
    with pytest.warns(MissingValuesWarning, match="mesh"):
        TactileArrays(place, "default/train", ["mesh"])
    dropped = TactileArrays(place, "default/train", ["mesh"], missing="drop")
    frames = dropped.batch(range(len(dropped)))
    assert (frames["frame"] < replayed_frames).all()
    assert np.isfinite(frames["mesh"]).all()
    assert dropped.report.left_out["without values of mesh"] > 0


def test_normalising_takes_wrenches_and_leaves_nodes(replayed):
    """The simulated wrench has mean 0 over train; nodes are not scaled, and asking for it is an error."""
    data = TactileArrays(replayed, "default/train", ["mesh", "mesh_wrench"], normalise=True, missing="keep")
    assert list(data.normalisers) == ["mesh_wrench"]
    batch = data.batch(range(len(data)))
    assert np.allclose(batch["mesh_wrench"].mean(axis=0), 0.0, atol=1e-4)
    assert np.array_equal(batch["mesh"], data.store.mesh("coarse").displacement(batch["frame"]))
    with pytest.raises(UsageError, match="mesh"):
        TactileArrays(replayed, "default/train", ["mesh"], normalise=["mesh"])
