"""Settings and worlds for every test."""

import gc
import os
import sys
from functools import cache
from itertools import chain, islice

import pytest
from hypothesis import HealthCheck, settings

# Collection makes a million objects that stay: searching them for garbage took a third of its time.
gc.disable()
GARBAGE = (20_000, 10, 10)
"""Thresholds of the collector during the tests. With Python's own, of 700 objects, about a tenth of the time goes into
searches that find little: tests leave few objects behind that refer to one another."""

SLOW = ("slow", "nightly")
"""Markers of tests that take seconds."""

# shared machines stall: a slow example is no failure
settings.register_profile("house", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("quick", settings.get_profile("house"), max_examples=33)
# `make test` tries three times as many examples of each law as `make quick`
settings.load_profile("house" if os.environ.get("TACTILE_REQUIRE_ALL") else "quick")


# tests run beside each other: commands that simulate start no processes of their own unless a test asks for them
os.environ.setdefault("TACTILEDATA_WORKERS", "1")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Each of several workers begins with files of slow tests, so that none waits at the end for another's long test.

    A worker gets a stretch of the list, and takes from the end of another's stretch once its own is done. Files stay
    whole, for their fixtures.
    """
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    if workers > 1:
        items[:] = slow_files_first(items, workers)


def slow_files_first(items, workers):
    """The tests in a stretch for each worker, all of equal length; files with slow tests are dealt out in turn."""
    slow = list(dict.fromkeys(item.path for item in items if any(map(item.get_closest_marker, SLOW))))
    turn = {path: number % workers for number, path in enumerate(slow)}
    stretches = [[item for item in items if turn.get(item.path) == worker] for worker in range(workers)]
    quick = iter([item for item in items if item.path not in turn])
    for stretch in stretches:
        stretch += islice(quick, max(len(items) // workers - len(stretch), 0))
    return [*chain(*stretches), *quick]


def pytest_collection_finish():
    """What imports and collection made stays to the end, so the collector need not look at it during the tests.

    Typer builds all commands anew in each of some hundred runs of the command line: here it builds them once.
    """
    if "typer.main" in sys.modules:
        building = sys.modules["typer.main"]
        building.get_command = cache(building.get_command)
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GARBAGE)
    gc.enable()


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """With TACTILE_REQUIRE_ALL=1, a test skipped for a missing package fails: a green full run hides nothing."""
    outcome = yield
    report = outcome.get_result()
    if report.skipped and os.environ.get("TACTILE_REQUIRE_ALL") and "could not import" in str(report.longrepr):
        report.outcome = "failed"


def tiny_world(folder, form):
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario

    return record(load_scenario(find_scenario("tiny")), folder, form)


@pytest.fixture(scope="session")
def tiny_mcaps(tmp_path_factory):
    """Two MCAP files of the bundled tiny world, and truth/ beside them; read only."""
    return tiny_world(tmp_path_factory.mktemp("tiny-mcap"), "mcap")


@pytest.fixture(scope="session")
def tiny_folders(tmp_path_factory):
    """The bundled tiny world as two folder logs; read only."""
    return tiny_world(tmp_path_factory.mktemp("tiny-folder"), "folder")


@pytest.fixture(scope="session")
def tiny_store(tiny_mcaps, tmp_path_factory):
    """A store of the tiny world with a split called default; read only."""
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

    place = tmp_path_factory.mktemp("tiny-store") / "ds.zarr"
    ingest(tiny_mcaps, place)
    make_split(Store.open(place), hold_out="none")
    return place


@pytest.fixture(scope="session")
def unstated(tiny_folders, tmp_path_factory):
    """A store of the tiny world whose logs do not state what they are; read only."""
    import yaml
    from copied_trees import copy_tree

    from tactiledata.ingest.pipeline import ingest

    place = tmp_path_factory.mktemp("unstated")
    logs = [copy_tree(folder, place / folder.name) for folder in tiny_folders]
    for log in logs:
        document = yaml.safe_load((log / "log.yaml").read_text())
        del document["recorded_by"]
        (log / "log.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    ingest(logs, place / "ds.zarr")
    return place / "ds.zarr"
