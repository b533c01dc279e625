"""Stores that tests export: a parted one of small pictures, and where the owners' loaders are."""

import os
import sys
from pathlib import Path

import pytest
from loader_stores import split_store


@pytest.fixture(scope="session")
def parted(tmp_path_factory):
    """A store of 24 trajectories in train, val and test, PNG pictures, three frames without a readable image."""
    return split_store(tmp_path_factory.mktemp("parted") / "ds.zarr", damaged=(3, 10, 40))


@pytest.fixture(scope="session")
def owners():
    """The folder of the owners' loaders, which `make owners` fills."""
    folder = Path(os.environ.get("TACTILE_OWNERS") or Path(sys.prefix) / "owners")
    if not (folder / "lerobot").is_dir():
        pytest.skip(f"could not import lerobot: {folder} is not there; run `make owners`")
    return folder
