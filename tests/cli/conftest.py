"""The bench that bad input is tried on."""

import pytest
from bench import Bench

from tactiledata.cli.failure import DEBUG_VARIABLE


@pytest.fixture
def bench(tmp_path, tiny_folders, tiny_mcaps, tiny_store, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(DEBUG_VARIABLE, raising=False)
    return Bench(tmp_path, tiny_folders[0], tiny_mcaps[0], tiny_store, monkeypatch)
