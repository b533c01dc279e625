"""The steps of an ingest one by one, over sources and takes that are a few facts."""

import dataclasses
import json
import re
import shutil

import numpy as np
import pyarrow as pa
import pytest

from tactiledata.compute.base import Outcome
from tactiledata.contract.lfs_pointer import START as POINTER
from tactiledata.contract.provenance import digest_of, file_digest, files_digest
from tactiledata.contract.records import Finding, Source
from tactiledata.contract.take import findings_of, findings_table
from tactiledata.errors import BrokenLog, MissingFile
from tactiledata.ingest import pipeline
from tactiledata.ingest.pipeline import ingest, source_digest
from tactiledata.ingest.sources.reports import SourceReport
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.layout.manifest import read_manifest
from tactiledata.store.read.reader import Store
from tactiledata.store.write import commit
from tests.ingest.made_takes import take
from tests.ingest.sources.test_replacing_plan import Staged


def task(key="run"):
    return pipeline._Task(Source("p", key, "folder", ()), key, "store", IngestOptions(), frozenset(), False)


def outcome(sha256=None, staged=None, error=None, key="run"):
    return Outcome(task(key), None if sha256 is None else pipeline._Read(sha256, staged), error)


def test_what_became_of_a_source_is_reported():
    """Failed, present, or added; what the store took otherwise is said of what is present."""
    failed = pipeline._report(outcome(error=BrokenLog("broken", "whole")), set(), set())
    assert (failed.state, failed.sha256) == ("failed", "")
    assert "broken" in failed.error
    present = pipeline._report(outcome("a"), set(), {"b"})
    assert (present.state, present.sha256, present.findings) == ("present", "a", ())
    [other] = pipeline._report(outcome("a"), set(), {"a"}).findings
    assert (other.code, other.severity) == ("ingested-otherwise", "warning")
    added = pipeline._report(outcome("a", Staged("a")), {"b"}, {"a"})
    assert (added.state, added.key, added.sha256) == ("added", "run", "a")
    assert [one.code for one in added.findings] == ["a"]
    assert pipeline._report(outcome("a", Staged("a")), {"a"}, set()).state == "present"


def test_each_take_is_committed_once():
    """What failed, what the store has and a second copy are reported only; those after them come in."""
    reports = []
    outcomes = [
        outcome(error=BrokenLog("x", "y")), outcome("a", Staged("a")), outcome("a", Staged("a")), outcome("b"),
        outcome("c", Staged("c")), outcome("d", Staged("d")),
    ]  # fmt: skip
    taken = pipeline._staged_takes(iter(outcomes), {"c"}, set(), reports)
    assert [one.sha256 for one in taken] == ["a", "d"]
    assert [one.state for one in reports] == ["failed", "added", "present", "present", "present", "added"]


def test_progress_is_told_of_every_source():
    """How many are read, from 1, of how many, and how many are stored; without a listener the outcomes are the same."""
    outcomes = [outcome(key="a"), outcome(key="b")]
    told = []
    watch = pipeline._Watch(2, lambda *said: told.append(said))
    for _ in pipeline._told(iter(outcomes), watch):
        watch.stored(len(told))
    assert told == [
        (1, 2, "a read"),
        (1, 2, "1 stored so far"),
        (2, 2, "b read, 1 stored so far"),
        (2, 2, "4 stored so far"),
    ]
    assert list(pipeline._told(iter(outcomes), pipeline._Watch(2, None))) == outcomes
    assert str(task("a")) == "a"


def test_progress_never_says_more_than_the_store_holds(tmp_path, monkeypatch):
    """Each number of stored recordings that progress tells is the number that the store holds at that moment."""
    monkeypatch.setattr(commit, "GROUP_TAKES", 2)
    for number in range(5):
        picture_folder(tmp_path / "in" / f"run{number}", count=2 + number)
    said = []

    def look(done, total, what):
        found = re.search(r"(\d+) stored", what)
        stored = int(found[1]) if found else 0
        said.append(stored)
        assert stored == len(read_manifest(tmp_path / "ds.zarr")["sources"])

    ingest([tmp_path / "in"], tmp_path / "ds.zarr", progress=look)
    assert said[-1] == 5
    assert sorted(set(said)) == [0, 2, 4, 5]


def test_a_copy_within_one_call_is_told_as_one(tmp_path):
    """A copy names the source that came in; what the store held before is no copy of anything."""
    picture_folder(tmp_path / "in" / "one")
    shutil.copytree(tmp_path / "in" / "one", tmp_path / "in" / "two")
    first = ingest([tmp_path / "in"], tmp_path / "ds.zarr")
    assert [(one.state, one.copy_of) for one in first.sources] == [("added", ""), ("present", first.sources[0].key)]
    assert first.document()["sources"][1]["copy_of"] == first.sources[0].key
    again = ingest([tmp_path / "in"], tmp_path / "ds.zarr")
    assert [(one.state, one.copy_of) for one in again.sources] == [("present", ""), ("present", "")]


def test_an_outcome_for_replacing():
    """Key, take and error; empty words where there is none."""
    staged = Staged("a")
    assert pipeline._as_read(outcome("a", staged)) == ("run", staged, "")
    key, nothing, error = pipeline._as_read(outcome(error=BrokenLog("broken", "whole")))
    assert (key, nothing) == ("run", None)
    assert "broken" in error


def test_a_status_gets_worse_by_damage_only():
    """A warning leaves it as it is."""
    warning, damage = Finding("a", "warning", "a"), Finding("b", "damage", "b")
    assert pipeline._worse("ok", [warning]) == pipeline._worse("ok", []) == "ok"
    assert pipeline._worse("unverified", [warning, damage]) == "damaged"


def test_strict_refuses_any_damage():
    """The first is named, and how many more there are."""
    source = Source("p", "run", "folder", ())

    def refused(*severities):
        findings = [Finding("a", severity, f"number {place}") for place, severity in enumerate(severities)]
        pipeline._refuse_damage(dataclasses.replace(take(), findings=findings_table(findings)), source)

    refused("info", "warning")
    with pytest.raises(BrokenLog, match=r"run is damaged: number 1$|run is damaged: number 1[^(]") as error:
        refused("warning", "damage")
    assert "more" not in str(error.value).partition("Leave")[0]
    with pytest.raises(BrokenLog, match=r"number 0 \(and 2 more\)"):
        refused("damage", "damage", "info", "damage")


def test_the_digest_of_a_source(tmp_path):
    """One file is known by its content, several by names and contents; a part of it is another source."""
    one, other = tmp_path / "a.bin", tmp_path / "sub" / "b.bin"
    other.parent.mkdir()
    one.write_bytes(b"a")
    other.write_bytes(b"b")

    def digest(path, *files, part=""):
        return source_digest(Source(str(path), "k", "f", tuple(str(file) for file in files), part))

    assert digest(one, one) == file_digest(one)
    assert digest(tmp_path, one) == file_digest(one)
    assert digest(tmp_path, one, other) == files_digest(tmp_path, [one, other])
    assert digest(one, one, other) == files_digest(tmp_path, [one, other])
    assert digest(one, one, part="x") == digest_of([file_digest(one), "x"])
    with pytest.raises(MissingFile, match="vanished"):
        digest(one, one, tmp_path / "nobody")
    with pytest.raises(MissingFile):
        digest(tmp_path, tmp_path)


class Tables:
    def __init__(self, rows):
        self.rows = rows

    @classmethod
    def of(cls, monkeypatch, rows):
        monkeypatch.setattr(pipeline, "Store", type("Store", (), {"open": staticmethod(lambda folder: cls(rows))}))

    def sources(self, columns):
        return pa.Table.from_pylist(self.rows).select(columns)


def test_sources_that_were_taken_with_other_options(monkeypatch, tmp_path):
    """Other options are known by their digest, and a store of before there were any took its sources otherwise."""
    mine = digest_of(IngestOptions().document())
    settings = {"a": {"settings_sha256": mine}, "b": {"settings_sha256": "x"}, "c": {}}
    rows = [{"sha256": name, "provenance": json.dumps(value)} for name, value in settings.items()]
    Tables.of(monkeypatch, rows)
    assert pipeline._ingested_otherwise(tmp_path, IngestOptions()) == {"b", "c"}


def test_twins_and_conflicts_are_added_to_the_reports(monkeypatch, tmp_path):
    """Conflicts of what came in only, before the twin; what was said before stays first."""
    asked = []

    def beside(store):
        return {0: (Finding("twin", "warning", "t"),), 2: (Finding("twin", "warning", "t"),)}

    def conflicts(store, digests):
        asked.append(sorted(digests))
        return {"a": (Finding("one", "warning", "1"), Finding("two", "warning", "2"))}

    Tables.of(monkeypatch, [{"sha256": name, "key": name} for name in ("a", "x", "p")])
    monkeypatch.setattr(pipeline, "findings_beside", beside)
    monkeypatch.setattr(pipeline, "conflict_findings", conflicts)
    before = (Finding("before", "info", "b"),)
    states = {"a": "added", "r": "replaced", "p": "present"}
    reports = [SourceReport(name, state, findings=before, sha256=name) for name, state in states.items()]
    found = pipeline._compared([*reports, SourceReport("f", "failed")], tmp_path)
    assert asked == [["a", "r"]]
    assert [[one.code for one in report.findings] for report in found] == [
        ["before", "one", "two", "twin"], ["before"], ["before", "twin"], [],
    ]  # fmt: skip


def test_a_waiting_take_is_used_where_it_was_read_with_the_same_options(monkeypatch, tmp_path):
    """A waiting take of the same source and options is used; another, or one read otherwise, is read again."""
    mine, other = Staged("a"), Staged("b")
    mine.document["provenance"] = {"settings_sha256": digest_of(IngestOptions().document())}
    other.document["provenance"] = {}
    monkeypatch.setattr(pipeline, "find_staged", lambda folder: {"a": mine, "b": other})
    assert pipeline._staged_so(tmp_path, "a", IngestOptions()) is mine
    assert pipeline._staged_so(tmp_path, "a", IngestOptions(gap_limit_ns=5)) is None
    assert pipeline._staged_so(tmp_path, "b", IngestOptions()) is None
    assert pipeline._staged_so(tmp_path, "c", IngestOptions()) is None


def picture_folder(place, count=3):
    """A recording of a few grey PNGs."""
    import cv2

    place.mkdir(parents=True)
    for number in range(count):
        cv2.imwrite(str(place / f"{number}.png"), np.full((8, 6, 3), 10 * number, np.uint8))
    return place


def test_pictures_become_a_store(tmp_path):
    """Pictures become a store and are told as they come; again, or with ``replace``, nothing changes."""
    log, store, told = picture_folder(tmp_path / "run"), tmp_path / "ds.zarr", []
    report = ingest([log], store, progress=lambda *said: told.append(said))
    assert [(one.state, one.frames) for one in report.sources] == [("added", 3)]
    assert told == [(1, 1, "run read"), (1, 1, "1 stored so far")]
    assert (report.store, report.unclaimed, report.findings, report.stale_splits) == (str(store), (), (), ())
    assert [one.state for one in ingest([log], store).sources] == ["present"]
    assert [one.state for one in ingest([log], store, replace=True).sources] == ["present"]
    assert Store.open(store).n_frames == 3


def test_what_was_left_out_is_reported(tmp_path):
    """Files that nobody claims by name; pointers are counted, and their first is named."""
    picture_folder(tmp_path / "in" / "run")
    (tmp_path / "in" / "notes.txt").write_text("x")
    for name in ("a.bin", "b.bin"):
        (tmp_path / "in" / name).write_bytes(POINTER + b"\n")
    report = ingest([tmp_path / "in"], tmp_path / "ds.zarr")
    assert report.unclaimed == (str(tmp_path / "in" / "notes.txt"),)
    [finding] = report.findings
    assert (finding.code, finding.severity, finding.count) == ("not-fetched", "warning", 2)
    assert "a.bin" in finding.message
    assert "1 more" in finding.message


def test_splits_that_cannot_be_used_are_named_where_the_store_changed(tmp_path, monkeypatch):
    """Splits that the store has no longer are named if it changed, and not if nothing came in."""
    log, store = picture_folder(tmp_path / "run"), tmp_path / "ds.zarr"
    ingest([log], store)
    monkeypatch.setattr(Store, "split_names", lambda self: ["default"])
    assert ingest([log], store).stale_splits == ()
    assert ingest([picture_folder(tmp_path / "more", 4)], store).stale_splits == ("default",)


def test_images_that_end_too_early_are_flagged_and_make_damage(tmp_path):
    """Said once, in the row of the store; the others are whole, and strict refuses the recording."""
    log = picture_folder(tmp_path / "run", 4)
    content = (log / "1.png").read_bytes()
    (log / "1.png").write_bytes(content[:-20])
    report = ingest([log], tmp_path / "ds.zarr")
    assert (report.sources[0].status, report.fell_short) == ("damaged", True)
    codes = [one.code for one in findings_of(Store.open(tmp_path / "ds.zarr").findings())]
    assert len([code for code in codes if code in ("image-truncated", "image-broken")]) >= 1
    flags = Store.open(tmp_path / "ds.zarr").frames(["flags"])["flags"].to_numpy()
    assert (flags & 3 != 0).sum() == 1
    refused = ingest([log], tmp_path / "strict.zarr", IngestOptions(strict=True))
    assert [one.state for one in refused.sources] == ["failed"]
