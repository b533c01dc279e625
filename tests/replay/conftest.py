"""Replays on a coarse pad, whose compliance is kept in a folder of the tests' own."""

import pytest
from coarse import options
from copied_trees import copy_tree

from tactiledata.replay.attach import replay


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def replayed(tiny_store, tmp_path_factory):
    """The tiny store with the mesh ``coarse``; read only."""
    place = tmp_path_factory.mktemp("replayed") / "ds.zarr"
    copy_tree(tiny_store, place)
    report = replay(place, options())
    assert not report.fell_short
    return place


@pytest.fixture
def copied(tiny_store, tmp_path):
    """A copy of the tiny store, without meshes."""
    place = tmp_path / "ds.zarr"
    copy_tree(tiny_store, place)
    return place
