"""What is said of twins and of conflicts, over stores that are only their tables."""

import pyarrow as pa
from test_twins import touch

from tactiledata.contract.records import Finding
from tactiledata.contract.take import findings_table
from tactiledata.errors import MissingFile
from tactiledata.ingest.checks.conflicts import conflict_findings
from tactiledata.ingest.checks.twins import ABSOLUTE, overlaps, twin_rows, twins_of_store
from tests.ingest.made_takes import frames


class Tables:
    """A store that is its tables."""

    def __init__(self, n_sources, touches=(), findings=()):
        names = [f"s{row}" for row in range(n_sources)]
        self.manifest = {"sources": names}
        self._sources = pa.table({"sha256": names, "key": [f"log{row}" for row in range(n_sources)]})
        self._touches = [
            {"uid": f"u{row}", "trajectory": f"t{row}", "indenter": "ball4", **touch}
            for row, touch in enumerate(touches)
        ]
        self.location = "ds.zarr"
        table = findings_table([finding for _, finding in findings])
        column = pa.array([source for source, _ in findings], pa.int32())
        self._findings = table.set_column(0, "source", column)

    def sources(self, columns):
        return self._sources.select(columns)

    def trajectories(self, columns):
        rows = [{name: touch[name] for name in columns} for touch in self._touches]
        return pa.Table.from_pylist(rows)

    def frames(self, columns):
        return frames(0).select(columns)

    def read_file(self, name):
        raise MissingFile(name, "a file")

    def findings(self):
        return self._findings


def test_three_twins_are_named_and_the_others_counted():
    """Three twins are named with how many touches they share, in the order of the store."""
    five = Tables(5, [touch(source, 0, 10) for source in (0, 0, 1, 2, 3, 4, 4)])
    found = twins_of_store(five)
    assert list(found) == [0, 1, 2, 3, 4]
    assert (found[0].code, found[0].severity, found[0].count) == ("recording-twin", "warning", 8)
    assert "too: log1 (2), log2 (2), log3 (2) and 1 more recordings. One may" in found[0].message
    four = Tables(4, [touch(source, 0, 10) for source in range(4)])
    assert "too: log0 (1), log1 (1), log3 (1). One may" in twins_of_store(four)[2].message
    assert twins_of_store(Tables(2, [touch(0, 0, 10), touch(1, 20, 30)])) == {}


def test_a_touch_that_overlaps_several_counts_once():
    """A long touch beside three short ones of another source counts once, and the other counts three."""
    short = [touch(1, start, start + 5) for start in (0, 10, 20)]
    assert overlaps([touch(0, 0, 30), *short]) == {0: {1: 1}, 1: {0: 3}}


def test_touches_meet_where_they_overlap_by_a_nanosecond():
    """One that ends where another begins does not meet it, nor does one without length or before the year 2001."""
    assert overlaps([touch(0, 0, 10), touch(1, 9, 20)]) == {0: {1: 1}, 1: {0: 1}}
    assert overlaps([touch(0, 0, 10), touch(1, 10, 20)]) == {}
    assert overlaps([touch(0, 0, 10), touch(1, 5, 5)]) == {}
    assert overlaps([touch(0, 0, 1), touch(1, 0, 1)]) != {}
    assert overlaps([touch(0, 0, 10), touch(1, 0, 10)]) != {}
    assert overlaps([touch(0, -1, 10), touch(1, 0, 10)]) == {}
    assert ABSOLUTE == 10**18


def test_what_ended_before_does_not_count_and_what_came_before_does():
    """Of three touches in a row the first ends before the third; what is left out ends the search for no other."""
    found = overlaps([touch(0, 0, 10), touch(1, 5, 25), touch(2, 10, 30), touch(3, 0, 9, sensor=""), touch(2, 40, 41)])
    assert found == {0: {1: 1}, 1: {0: 1, 2: 1}, 2: {1: 1}}
    derived = [touch(0, 0, 10, parent="ab"), touch(0, 20, 30), touch(1, 20, 30)]
    assert overlaps(derived) == {0: {1: 1}, 1: {0: 1}}


def test_the_first_conflict_of_each_stream_is_said():
    """The first conflict of each stream is said, of the sources that are asked for and of no other kind of finding."""
    rows = [
        (0, Finding("sensor-conflict", "warning", "one", "D1")),
        (1, Finding("sensor-conflict", "warning", "two", "D1")),
        (1, Finding("gap", "warning", "a gap", "D1")),
        (1, Finding("sensor-conflict", "warning", "again", "D1")),
        (1, Finding("sensor-conflict", "warning", "three", "D2")),
        (1, Finding("signal-variant", "warning", "four", "D1")),
    ]
    found = conflict_findings(Tables(2, (), rows), {"s1"})
    assert {digest: [one.message for one in all_] for digest, all_ in found.items()} == {"s1": ["two", "three", "four"]}
    assert set(conflict_findings(Tables(2, (), rows), {"s0", "s1"})) == {"s0", "s1"}


def test_the_copies_of_a_touch_are_found_by_row():
    """All touches of other recordings that overlap one that is asked for are found, these themselves are not."""
    store = Tables(3, [touch(0, 0, 10), touch(1, 5, 15), touch(2, 30, 40), touch(2, 9, 20), touch(0, 50, 60)])
    assert twin_rows(store, [0]) == [1, 3]
    assert twin_rows(store, [1]) == [0, 3]
    assert twin_rows(store, [0, 1]) == [3]
    assert twin_rows(store, [2, 4]) == []
