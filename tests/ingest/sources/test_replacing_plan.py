"""Which take replaces which recording, over takes and stores that are a few facts."""

import json
from pathlib import Path

import pyarrow as pa
import pytest

from tactiledata.contract.records import Finding
from tactiledata.contract.take import findings_table
from tactiledata.errors import UnknownName
from tactiledata.ingest.sources import replacing
from tactiledata.ingest.sources.replacing import Plan, StoredRecordings, plan, replace_recordings
from tactiledata.ingest.sources.reports import IngestReport, SourceReport, report_of
from tests.ingest.made_takes import frames


class Staged:
    """A staged take: its digest, name, checksums of log stamps and its images (height, width, checksum)."""

    n_frames = 3
    folder = Path("nowhere")

    def __init__(self, sha256, key="run", stamps=(), images=(), content="c", references=(), encoding="png"):
        self.sha256, self.images, self.encoding = sha256, list(images), encoding
        self.document = {
            "key": key, "content": content, "references": list(references), "status": "ok",
            "description": {"recorded_by": {"contact": "simulated"}},
            "signals": {f"s{n}": {"arrays": {"log_ns": {"crc32c": crc}}} for n, crc in enumerate(stamps)},
        }  # fmt: skip

    def renamed(self, key):
        self.document["key"] = key
        return self

    def table(self, name):
        if name == "trajectories":
            return pa.table({"a": [1, 2]})
        if name == "findings":
            return findings_table([Finding("a", "info", "found")])
        return pictures([(0, *image) for image in self.images], self.encoding)


def pictures(rows, encoding="png"):
    """A table of frames of (source, height, width, checksum)."""
    columns = list(zip(*rows, strict=True)) or [()] * 4
    return frames(
        len(rows), source=columns[0], height=columns[1], width=columns[2], crc32c=columns[3], encoding=encoding
    ) if rows else frames(0)  # fmt: skip


class Tables:
    """A store of sources with (sha256, key, number of frames, checksums of log stamps), and all of its images."""

    def __init__(self, sources=(), images=(), references=(), encoding="png"):
        self.rows = [
            {"sha256": sha, "key": key, "frames": count, "contents": json.dumps({
                "content": "c", "signals": {f"s{n}": {"crc32c": {"log_ns": crc}} for n, crc in enumerate(stamps)},
            })}
            for sha, key, count, stamps in sources
        ]  # fmt: skip
        self.table = pictures(images, encoding)
        self.manifest = {"references": {name: {} for name in references}}

    def sources(self, columns):
        return pa.Table.from_pylist(self.rows).select(columns)

    def frames(self, columns):
        return self.table.select(columns)

    def reference(self, sensor):
        if sensor not in self.manifest["references"]:
            raise UnknownName("sensor", sensor, self.manifest["references"])


def matches(staged, *sources, **options):
    return StoredRecordings(Tables(sources, **options)).matches(staged)


def test_the_same_files_are_the_same_recording():
    """Whatever their name."""
    assert matches(Staged("a", "other"), ("a", "run", 0, ()), ("b", "run", 0, ())) == ["a"]


def test_the_same_name_and_a_signal_in_common():
    """Equal log stamps of any signal; stamps of no samples are equal everywhere, and count for nothing."""
    stored = ("a", "run", 0, (5, 6))
    assert matches(Staged("b", stamps=[6]), stored) == ["a"]
    assert matches(Staged("b", stamps=[7, 6]), stored) == ["a"]
    assert matches(Staged("b", "other", stamps=[6]), stored) == []
    assert matches(Staged("b", stamps=[7]), stored) == []
    assert matches(Staged("b", stamps=[0]), ("a", "run", 0, (0,))) == []
    assert matches(Staged("b", stamps=[1]), ("a", "run", 0, (1,))) == ["a"]


def test_the_same_name_and_an_image_in_common():
    """Images in common have equal size and bytes and are of that very source; moments without an image do not count."""
    stored = [("a", "run", 2, ()), ("b", "run", 1, ())]
    images = [(0, 8, 6, 1), (0, 8, 6, 2), (1, 8, 6, 3)]
    assert matches(Staged("c", images=[(8, 6, 3)]), *stored, images=images) == ["b"]
    assert matches(Staged("c", images=[(8, 6, 9), (8, 6, 2)]), *stored, images=images) == ["a"]
    assert matches(Staged("c", images=[(6, 8, 2)]), *stored, images=images) == []
    assert matches(Staged("c", images=[(8, 6, 4)]), *stored, images=images) == []
    assert matches(Staged("c", images=[(8, 6, 3)], encoding="missing"), *stored, images=images) == []
    assert matches(Staged("c"), *stored, images=images) == []


def test_the_last_part_of_a_name_is_enough_where_one_recording_alone_has_it():
    """A file that is given in place of its folder is the recording that came with the folder, if it holds the same."""
    monday, tuesday = ("a", "monday/run", 1, (5,)), ("b", "tuesday/run", 1, (5,))
    assert matches(Staged("c", "run", stamps=[5]), monday) == ["a"]
    assert matches(Staged("c", "wednesday/run", stamps=[5]), monday) == ["a"]
    assert matches(Staged("c", "run", stamps=[6]), monday) == []
    assert matches(Staged("c", "another", stamps=[5]), monday) == []
    assert matches(Staged("c", "run", stamps=[5]), monday, tuesday) == []
    # the whole name comes first: the other recording stays
    assert matches(Staged("c", "tuesday/run", stamps=[5]), monday, tuesday) == ["b"]


def test_ends_of_its_path_are_names_of_a_recording():
    """What came in by its last part, and later with its folder, is the same recording; another folder's is not."""
    stored = [("a", "run", 1, (5,)), ("b", "monday/run", 1, (5,)), ("c", "tuesday/run", 1, (5,))]
    names = ["run", "monday/run", "lab/monday/run"]
    assert StoredRecordings(Tables(stored)).matches(Staged("d", "run", stamps=[5]), names) == ["a", "b"]
    assert StoredRecordings(Tables(stored)).matches(Staged("d", "run", stamps=[6]), names) == []


def test_a_whole_name_takes_its_recording_before_a_part_of_one_does():
    """Two staged copies, of which one has the whole name, replace the recording by that one, whatever their order."""
    stored = StoredRecordings(Tables([("a", "monday/run", 1, (5,))]))
    whole, part = Staged("b", "monday/run", stamps=[5]), Staged("c", "run", stamps=[5])
    for takes in ([whole, part], [part, whole]):
        chosen = plan(stored, takes)
        assert list(chosen.replacements.values()) == [whole]
        assert chosen.new == [part]


@pytest.fixture
def asked(monkeypatch):
    """Rows and ranges whose payloads and values were checked; each has the faults that are put in."""
    seen = {"payloads": [], "values": [], "payload faults": [], "value faults": []}

    def payload_faults(store, rows):
        seen["payloads"].append((rows.start, rows.stop))
        return seen["payload faults"]

    def source_value_findings(store, key, contents, rows):
        seen["values"].append((key, rows))
        return seen["value faults"]

    monkeypatch.setattr(replacing, "payload_faults", payload_faults)
    monkeypatch.setattr(replacing, "source_value_findings", source_value_findings)
    return seen


def holds(staged, **options):
    rows = [("a", "one", 3, ()), ("b", "two", 4, ())]
    return StoredRecordings(Tables(rows, **options)).holds(staged)


def test_a_store_holds_a_take_whose_content_is_undamaged(asked):
    """Its own images and values are looked at, and its references are there."""
    assert holds(Staged("b"))
    assert asked["payloads"] == [(3, 7)]
    assert asked["values"] == [("two", (3, 7))]
    assert holds(Staged("a"))
    assert asked["payloads"][1:] == [(0, 3)]
    assert not holds(Staged("c"))
    assert not holds(Staged("b", content="other"))
    assert holds(Staged("b", references=["D1"]), references=["D1", "D2"])
    assert not holds(Staged("b", references=["D1", "D3"]), references=["D1", "D2"])


@pytest.mark.parametrize("fault", ["payload faults", "value faults"])
def test_a_store_does_not_hold_what_is_damaged(asked, fault):
    """Be it an image or a number."""
    asked[fault] = [Finding("a", "damage", "a")]
    assert not holds(Staged("b"))


class Known:
    """Stored recordings of which the matches and what is held are stated."""

    def __init__(self, matches, held=()):
        self._matches, self._held = matches, held

    def matches(self, staged, names):
        return self._matches.get(staged.sha256, [])

    def holds(self, staged):
        return staged.sha256 in self._held

    def is_exact(self, staged):
        return True

    def alike(self, staged):
        return ["mon/a"] if staged.sha256 == "n" else []

    def key(self, sha256):
        return f"old {sha256}"


def planned(takes, matches, held=()):
    made = [Staged(sha) for sha in takes]
    found = plan(Known(matches, held), made)
    return {
        "replaced": {old: new and new.sha256 for old, new in found.replacements.items()},
        "new": [one.sha256 for one in found.new],
        "held": [one.sha256 for one in found.held],
        "states": [found.state(one) for one in made],
    }


def test_a_take_that_matches_nothing_is_new():
    """A take that matches nothing is new and replaces nothing; one that is listed twice comes once."""
    assert planned(["a", "b"], {}) == {"replaced": {}, "new": ["a", "b"], "held": [], "states": ["added"] * 2}
    assert planned(["a", "a", "b"], {}) == {
        "replaced": {}, "new": ["a", "b"], "held": ["a"], "states": ["added", "present", "added"],
    }  # fmt: skip


def test_a_take_with_the_same_files_is_held_or_mended():
    """Held where the store has it undamaged; where it matches others, too, these go."""
    assert planned(["a"], {"a": ["a"]}, ["a"])["states"] == ["present"]
    assert planned(["a"], {"a": ["a"]}) == {"replaced": {"a": "a"}, "new": [], "held": [], "states": ["replaced"]}
    assert planned(["a"], {"a": ["x", "a", "y"]}, ["a"])["replaced"] == {"x": "a", "a": None, "y": None}


def test_each_recording_is_replaced_once_by_the_take_with_the_same_files_first():
    """The other take, which only has the same name, is new."""
    found = planned(["b", "a"], {"a": ["a"], "b": ["a"]})
    assert found == {"replaced": {"a": "a"}, "new": ["b"], "held": [], "states": ["added", "replaced"]}
    found = planned(["b", "a", "c"], {"a": ["a"], "b": ["a", "z"]}, ["a"])
    assert found == {
        "replaced": {"z": "b"}, "new": ["c"], "held": ["a"], "states": ["replaced", "present", "added"],
    }  # fmt: skip


def test_what_was_replaced_is_committed_and_reported(monkeypatch, tmp_path):
    """New takes in their order, replacements where there are any; what is held is swept away."""
    done = []
    said = [Finding("b", "info", "b")]
    monkeypatch.setattr(replacing, "Store", type("Store", (), {"open": staticmethod(lambda folder: None)}))
    monkeypatch.setattr(replacing, "StoredRecordings", lambda store: Known({"a": ["a"], "h": ["h"]}, ["h"]))
    monkeypatch.setattr(
        replacing,
        "replace_takes",
        lambda folder, found: done.append([(sha, take.document["key"]) for sha, take in found.items()]) or said,
    )
    monkeypatch.setattr(replacing, "commit_groups", lambda folder, takes: done.append([one.sha256 for one in takes]))
    takes = {sha: Staged(sha) for sha in ("a", "h", "n", "m")}
    takes["h"].folder = tmp_path / "held"
    takes["h"].folder.mkdir()
    read = [("a", takes["a"], ""), ("bad", None, "broken"), *((sha, takes[sha], "") for sha in ("n", "h", "m"))]
    reports, findings = replace_recordings(tmp_path, read)
    assert done == [[("a", "old a")], ["n", "m"]]
    assert "mon/a holds images or times of it" in reports[2].findings[-1].message
    assert "give it the name a, and ingest" in reports[2].findings[-1].message
    assert "holds images" not in reports[4].findings[-1].message
    assert findings == said
    assert [(one.key, one.state) for one in reports] == [
        ("a", "replaced"), ("bad", "failed"), ("n", "added"), ("h", "present"), ("m", "added"),
    ]  # fmt: skip
    assert reports[1].error == "broken"
    assert reports[3].sha256 == "h"
    assert [[one.code for one in report.findings] for report in reports] == [
        ["a"], [], ["a", "nothing-replaced"], [], ["a", "nothing-replaced"],
    ]  # fmt: skip
    assert not takes["h"].folder.exists()
    done.clear()
    assert replace_recordings(tmp_path, read[1:2])[1] == []
    assert done == [[]]


def test_copies_of_what_is_held_share_a_folder_that_is_swept_away_once(monkeypatch, tmp_path):
    """The same bytes under two names are staged in one folder; that it is gone by then is no error."""
    monkeypatch.setattr(replacing, "Store", type("Store", (), {"open": staticmethod(lambda folder: None)}))
    monkeypatch.setattr(replacing, "StoredRecordings", lambda store: Known({"h": ["h"]}, ["h"]))
    monkeypatch.setattr(replacing, "commit_groups", lambda folder, takes: None)
    one, copy = Staged("h"), Staged("h")
    one.folder = copy.folder = tmp_path / "held"
    one.folder.mkdir()
    reports, _ = replace_recordings(tmp_path, [("h", one, ""), ("copy", copy, "")])
    assert [report.state for report in reports] == ["present", "present"]
    assert not one.folder.exists()


def test_a_plan_knows_takes_by_themselves():
    """Another take of the same digest is present."""
    one, other = Staged("a"), Staged("a")
    assert Plan({"x": one}, [], [other]).state(other) == "present"
    assert Plan({}, [one], []).state(one) == "added"


def test_a_report_holds_what_was_staged():
    """Numbers of the take, its own findings before those that are added, and its kind."""
    found = report_of("run", "added", Staged("a"), Finding("b", "info", "more"))
    assert (found.key, found.state, found.status, found.frames, found.trajectories) == ("run", "added", "ok", 3, 2)
    assert [one.code for one in found.findings] == ["a", "b"]
    assert (found.sha256, found.kind, found.error) == ("a", "simulated", "")


def reported(*sources):
    return IngestReport("s.zarr", tuple(SourceReport("k", **source) for source in sources), ())


def test_what_a_report_says_of_all_sources():
    """Whether the store changed, whether something fell short, and how many of what came in are simulated."""
    for state, changed, short in (
        ("added", True, False), ("replaced", True, False), ("present", False, False), ("failed", False, True),
    ):  # fmt: skip
        one = reported({"state": "present"}, {"state": state})
        assert (one.changed, one.fell_short) == (changed, short)
    assert reported({"state": "added", "status": "damaged"}).fell_short
    assert not reported({"state": "added", "status": "unverified"}).fell_short
    kinds = [{"state": state, "kind": "simulated"} for state in ("added", "replaced", "present")]
    assert reported(*kinds, {"state": "added"}).simulated.document() == {"simulated": 2, "real": 0, "not_stated": 1}


def test_a_report_as_json_values():
    """A report has every part as JSON values, findings as dictionaries."""
    finding = Finding("a", "info", "b", count=3)
    source = SourceReport("k", "failed", "damaged", 1, 2, (finding,), "broken", "sha", "real")
    found = json.loads(json.dumps(IngestReport("s.zarr", (source,), ("x",), (finding,), ("default",)).document()))
    assert found == {
        "store": "s.zarr", "unclaimed": ["x"], "stale_splits": ["default"], "fell_short": True,
        "findings": [vars(finding)], "simulated_recordings": {"simulated": 0, "real": 0, "not_stated": 0},
        "sources": [{
            "key": "k", "name": "k",
                "state": "failed", "status": "damaged", "frames": 1, "trajectories": 2, "kind": "real",
                "copy_of": "",
            "error": "broken", "findings": [vars(finding)],
        }],
    }  # fmt: skip
    plain = SourceReport("k", "present")
    assert (plain.status, plain.frames, plain.trajectories, plain.findings, plain.error) == ("", 0, 0, (), "")
    assert (plain.sha256, plain.kind) == ("", "not stated")
