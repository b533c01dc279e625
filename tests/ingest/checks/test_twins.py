"""Copies whose files differ are found by what they hold: one sensor at one time; clocks that start at 0 say nothing."""

import pandas as pd
import pytest
from copied_trees import copy_tree
from typer.testing import CliRunner

from tactiledata.cli.main import app
from tactiledata.errors import TactileDataError
from tactiledata.ingest.checks.twins import ABSOLUTE, need_touches_once, overlaps, twins_of_store
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.change.flag import flag_trajectories
from tactiledata.store.read.reader import Store


def touch(source, start, end, sensor="D20542", parent="", origin=ABSOLUTE):
    return {"source": source, "sensor": sensor, "start_ns": origin + start, "end_ns": origin + end, "parent": parent}


def test_one_sensor_at_one_time_makes_twins():
    """Each touch that overlaps one of another source is counted once, on both sides."""
    found = overlaps([touch(0, 0, 10), touch(0, 20, 30), touch(0, 40, 50), touch(1, 5, 25), touch(2, 60, 70)])
    assert found == {0: {1: 2}, 1: {0: 1}}


@pytest.mark.parametrize(
    "other",
    [
        touch(1, 10, 20),
        touch(1, 0, 10, sensor="D20001"),
        touch(1, 0, 10, sensor=""),
        touch(1, 0, 10, parent="ab"),
        touch(0, 0, 10),
        touch(1, 1, 10, sensor="unknown-22"),
    ],
    ids=["afterwards", "another sensor", "no sensor", "derived", "the same source", "unknown, another time"],
)
def test_others_are_no_twins(other):
    """Touches that end before the next begins, of other sensors, derived, or of one recording are no twins."""
    first = "unknown-11" if other["sensor"].startswith("unknown") else "D20542"
    assert overlaps([touch(0, 0, 10, sensor=first), other]) == {}


def test_a_clock_that_starts_at_zero_says_nothing():
    """Corpora whose times are indices all begin at 0, and are no copies of each other for that."""
    assert overlaps([touch(0, 0, 10, origin=0), touch(1, 0, 10, origin=0)]) == {}
    assert overlaps([touch(0, 0, 10), touch(1, 0, 10)]) != {}


def test_unknown_sensors_are_twins_at_equal_times():
    """A sensor without a name goes by the recording's digest, which a copy does not share; its times are the same."""
    assert overlaps([touch(0, 0, 10, "unknown-11"), touch(1, 0, 10, "unknown-22")]) == {0: {1: 1}, 1: {0: 1}}


@pytest.mark.slow
def test_an_edited_copy_is_said_at_ingest(tiny_folders, tiny_mcaps, tmp_path):
    """An edited copy is said in one run, in a later one and when it is there already; independent logs have no twin."""

    def said(report):
        return [[finding.code for finding in source.findings].count("recording-twin") for source in report.sources]

    store = tmp_path / "ds.zarr"
    assert said(ingest(tiny_folders, store)) == [0, 0]
    copy = tmp_path / "copy"
    copy_tree(tiny_folders[0], copy)
    text = (copy / "log.yaml").read_text()
    (copy / "log.yaml").write_text(text + "\n# edited\n")
    report = ingest([copy], store)
    assert said(report) == [1]
    [twin] = [finding for finding in report.sources[0].findings if finding.code == "recording-twin"]
    assert tiny_folders[0].name in twin.message
    assert twin.count == 2
    assert said(ingest([*tiny_folders, copy], store)) == [1, 0, 1]
    assert said(ingest([tiny_folders[1], copy, tiny_folders[0]], tmp_path / "once.zarr")) == [0, 1, 1]


@pytest.mark.slow
def test_a_copy_that_names_other_indenters_is_told_so(tiny_folders, tmp_path):
    """One of two labels of one touch is wrong, and a model would learn both; copies that agree get no such words."""
    place, copy = tmp_path / "ds.zarr", tmp_path / "copy"
    copy_tree(tiny_folders[0], copy)
    text = (copy / "log.yaml").read_text()
    (copy / "log.yaml").write_text(text + "\n# edited\n")
    ingest([tiny_folders[0], copy], place)
    alike = twins_of_store(Store.open(place))
    assert [("another indenter" in finding.message) for finding in alike.values()] == [False, False]
    table = pd.read_csv(copy / "trajectories.csv")
    first = table["indenter"].iloc[0]
    table.loc[0, "indenter"] = "cross" if first != "cross" else "ball4"
    table.to_csv(copy / "trajectories.csv", index=False)
    ingest([copy], place, replace=True)
    unlike = twins_of_store(Store.open(place))
    assert [("of 1 trajectory the other names another indenter" in one.message) for one in unlike.values()] == [
        True,
        True,
    ]
    assert f"({first} here, " in unlike[0].message


@pytest.mark.slow
def test_a_copy_that_replaces_its_origin_has_no_twin(tiny_folders, tmp_path):
    """With `--replace` only the edited log is left, and nothing is said; added beside its origin it is said."""
    log = tmp_path / "log"
    copy_tree(tiny_folders[0], log)
    ingest([log], tmp_path / "ds.zarr")
    with (log / "log.yaml").open("a") as stream:
        stream.write("\n# edited\n")
    copy_tree(tmp_path / "ds.zarr", tmp_path / "both.zarr")
    for store, replace, twins in (("ds.zarr", True, 0), ("both.zarr", False, 1)):
        [source] = ingest([log], tmp_path / store, replace=replace).sources
        assert source.state == ("replaced" if replace else "added")
        assert [finding.code for finding in source.findings].count("recording-twin") == twins


@pytest.mark.slow
def test_a_fit_refuses_touches_that_two_recordings_hold(tiny_folders, tmp_path):
    """Calibration and diagnosis refuse a copied recording, and name it; flagged, or alone, it is no obstacle."""
    place = tmp_path / "ds.zarr"
    ingest(tiny_folders, place)
    need_touches_once(Store.open(place))
    copy = tmp_path / "copy"
    copy_tree(tiny_folders[0], copy)
    with (copy / "log.yaml").open("a") as stream:
        stream.write("\n# edited\n")
    ingest([copy], place)
    with pytest.raises(TactileDataError, match=f"2 trajectories of copy .* {tiny_folders[0].name}.*flag .* copy"):
        need_touches_once(Store.open(place))
    for command in ("calibrate", "diagnose"):
        refused = CliRunner().invoke(app, [command, str(place), "--out", str(tmp_path / "out.json")]).exception
        assert isinstance(refused, TactileDataError)
        assert "this recording is a copy" in refused.found
    store = Store.open(place)
    sensor = store.trajectories(["sensor"])["sensor"].to_pylist()[0]
    need_touches_once(store, "another sensor")
    with pytest.raises(TactileDataError):
        need_touches_once(store, sensor)
    copied = [row["uid"] for row in store.trajectories(["uid", "source"]).to_pylist() if row["source"] == 2]
    flag_trajectories(str(place), copied, "a copy")
    need_touches_once(Store.open(place))
