"""PyTorch is needed, on one thread; what is computed once lies in a folder of the tests' own."""

import os
from importlib import import_module
from importlib.util import find_spec

import pytest

if find_spec("torch") is None and not os.environ.get("TACTILE_REQUIRE_ALL"):
    collect_ignore_glob = ["test_*.py"]
elif find_spec("triton") is not None:
    # CUDA builds of PyTorch load Triton with the first optimiser; its LLVM, loaded after that of numba had compiled for
    # some hundred tests of the gel, once ended the process. Loaded at collection it comes first.
    import_module("torch._dynamo")


@pytest.fixture(scope="session", autouse=True)
def _quiet_machine(tmp_path_factory):
    import torch

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.mktemp("cache")))
        patch.setenv("OMP_NUM_THREADS", "1")
        torch.set_num_threads(1)
        yield


@pytest.fixture(scope="session")
def short_store(tmp_path_factory):
    """A store of the bundled tiny world with one touch of each sensor instead of two; read only."""
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario

    place = tmp_path_factory.mktemp("short-store")
    world = find_scenario("tiny")
    short = {**world, "generate": {**world["generate"], "count": len(world["sensors"])}}
    ingest(record(load_scenario(short), place / "logs", "mcap"), place / "ds.zarr")
    return place / "ds.zarr"


@pytest.fixture(scope="session")
def touch_store(tmp_path_factory, _quiet_machine):
    """Twelve touches on three sensors, one of them unseen, with coarse meshes and a split; read only."""
    from touch_world import make_store

    return make_store(tmp_path_factory.mktemp("touches"))
