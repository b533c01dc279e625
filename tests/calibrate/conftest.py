"""Results that are kept go to a folder of the tests."""

import pytest


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    """One folder for all tests of a session, apart from the user's."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))
