"""Splits on disk: kept, loaded, brought up to date, and refused where they do not fit."""

import errno
import os
import re
import shlex

import numpy as np
import pyarrow.parquet as pq
import pytest
from split_cases import MemoryStore, frames, many, parts, trajectories

from tactiledata.contract.schema import check_document
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import LeakError, MissingSplit, SchemaError, StoreError, UnknownName, UsageError
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import frame_rows, load_split
from tactiledata.splits.options import PARTITIONS, read_force, read_fractions, read_hold_out


@pytest.fixture
def store(tmp_path):
    return MemoryStore(tmp_path, trajectories(many(100)))


def grown(store, n=140):
    return MemoryStore(store.folder, trajectories(many(n)))


def files(store, name="default"):
    return [store.split_path(name, suffix) for suffix in (".parquet", ".json")]


def test_round_trip(store):
    """What was made is what is loaded, and its document fits the schema."""
    report = make_split(store, seed=3)
    split = load_split(store, "default")
    check_document(split.document, "split", "the document")
    assert split.options == report.options
    assert split.held_out == report.held_out
    assert sum(count.trajectories for count in report.counts.values()) == 100
    assert report.document()["counts"]["train"] == split.document["counts"]["train"]
    assert "default" in report.lines()[0]


def test_parts_hold_every_taken_frame_once(store):
    """The frames of the four parts are disjoint and together all frames in contact."""
    make_split(store)
    split = load_split(store, "default")
    rows = np.concatenate([frame_rows(store, split, part) for part in PARTITIONS])
    assert sorted(rows) == list(range(store.n_frames))


def test_only_frames_in_contact_with_an_image_are_taken(tmp_path):
    """1 N and 13 N are in; less, more, no wrench, a missing or broken image, and free frames are out."""
    table = trajectories(many(10))
    force = np.tile([1.0, 13.0, 0.99], 10)
    force[3:6] = [13.01, np.nan, 5.0]
    flags = np.zeros(30, int)
    flags[6], flags[7], flags[9] = FrameFlag.MISSING, FrameFlag.BROKEN, FrameFlag.GAP
    owner = np.repeat(np.arange(10), 3)
    owner[10] = -1
    frame_table = frames(table, contact_force=force, flags=flags, trajectory=owner)
    store = MemoryStore(tmp_path, table, frame_table)
    report = make_split(store, hold_out="none")
    split = load_split(store, "default")
    rows = sorted(np.concatenate([frame_rows(store, split, part) for part in PARTITIONS]))
    expected = [row for row in range(30) if row % 3 != 2 or row == 5]
    assert rows == [row for row in expected if row not in (3, 4, 6, 7, 10)]
    assert sum(count.frames for count in report.counts.values()) == len(rows)
    assert any("no contact force" in note for note in report.notes)


def test_the_same_call_writes_the_same_bytes(store):
    """Making a split twice changes no byte."""
    make_split(store)
    before = [path.read_bytes() for path in files(store)]
    make_split(store)
    assert [path.read_bytes() for path in files(store)] == before


def test_growth_keeps_parts_and_held_out_units(store):
    """After data were added, loading says so; making it again moves nobody and keeps who is held out."""
    first = make_split(store)
    before = parts(load_split(store, "default").table)
    added = [{**row, "uid": f"a{k:015x}", "source": 1000 + k} for k, row in enumerate(many(100, "FGHIJKLMN"))]
    both = trajectories([*store.table.to_pylist(), *added])
    bigger = MemoryStore(store.folder, both)
    with pytest.raises(LeakError, match=r"100 new trajectories.*tactiledata split .* --name default"):
        load_split(bigger, "default")
    second = make_split(bigger)
    after = parts(load_split(bigger, "default").table)
    assert second.held_out == first.held_out
    assert any("held out as before" in note for note in second.notes)
    assert {uid: after[uid] for uid in before} == before


@pytest.mark.parametrize("count", [1, 3])
def test_who_is_parted_anew_is_counted_and_named(store, count):
    """Trajectories that turn out to be made of one in another part go there, and the note names the first of them."""
    make_split(store)
    before = parts(load_split(store, "default").table)
    rows = store.table.to_pylist()
    first_part = before[rows[0]["uid"]]
    moving = [row for row in rows if before[row["uid"]] != first_part][:count]
    for row in moving:
        row["parent"] = rows[0]["uid"]
    related = MemoryStore(store.folder, trajectories(rows))
    notes = make_split(related).notes
    after = parts(load_split(related, "default").table)
    assert [uid for uid, part in before.items() if after[uid] != part] == [row["uid"] for row in moving]
    words = "1 trajectory is" if count == 1 else "3 trajectories are"
    said = f"{words} in another part than before (first {moving[0]['uid']}):"
    assert [note for note in notes if note.startswith(said)]


def test_other_options_need_another_name_or_replace(store):
    """A split is not silently made anew with other options."""
    make_split(store, seed=0)
    with pytest.raises(UsageError, match="--seed 0 there, --seed 1 here"):
        make_split(store, seed=1)
    make_split(store, seed=1, name="other")
    make_split(store, seed=1, replace=True)
    assert load_split(store, "default").options.seed == 1


def test_a_split_killed_between_its_files_is_torn_and_heals(store):
    """A new table under an old document is refused, and the same command mends it."""
    make_split(store)
    table, document = files(store)
    old = document.read_bytes()
    bigger = grown(store)
    make_split(bigger)
    document.write_bytes(old)
    with pytest.raises(StoreError, match="changed or torn"):
        load_split(bigger, "default")
    make_split(bigger)
    assert load_split(bigger, "default").table.num_rows == 140
    table.unlink()
    with pytest.raises(StoreError, match="missing"):
        load_split(bigger, "default")
    make_split(bigger)
    load_split(bigger, "default")


def test_a_store_that_lost_trajectories_is_refused(store):
    """A split that names more than the store holds is out of date too."""
    make_split(grown(store))
    with pytest.raises(LeakError, match="40 trajectories of the split can no longer be found"):
        load_split(store, "default")


def test_changed_tables_are_refused(store):
    """Another table under the same document, bytes that are no parquet, and a document that is no JSON are refused."""
    make_split(store)
    table, document = files(store)
    good = table.read_bytes()
    pq.write_table(pq.read_table(table).slice(1), table)
    with pytest.raises(StoreError, match="changed or torn"):
        load_split(store, "default")
    table.write_bytes(good)
    load_split(store, "default")
    document.write_text("{")
    with pytest.raises(SchemaError, match="not JSON"):
        load_split(store, "default")
    document.write_text("{}")
    with pytest.raises(SchemaError, match="the key 'format' is missing"):
        load_split(store, "default")
    with pytest.raises(StoreError, match="--replace"):
        make_split(store)
    make_split(store, replace=True)


def test_missing_splits_say_how_to_make_one(store):
    """No split at all, and a name that is not there."""
    with pytest.raises(MissingSplit) as missing:
        load_split(store, "default")
    assert f"`{shlex.join(['tactiledata', 'split', store.location, '--by', 'trajectory,sensor'])}`" in str(
        missing.value
    )
    make_split(store)
    with pytest.raises(UnknownName, match=r"Did you mean default\?$"):
        load_split(store, "defualt")
    with pytest.raises(UnknownName, match="by-robot") as unknown:
        load_split(store, "by-robot")
    command = shlex.join(["tactiledata", "split", store.location, "--by", "trajectory,sensor", "--name", "by-robot"])
    assert f"Run `{command}` to make it." in str(unknown.value)
    with pytest.raises(UnknownName, match="test_unseen"):
        frame_rows(store, load_split(store, "default"), "testing")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"by": "frame"}, "tear trajectories apart"),
        ({"by": ("sensor",)}, "tear trajectories apart"),
        ({"by": ""}, "by nothing"),
        ({"by": "trajectory,colour"}, "'colour'"),
        ({"fractions": (0.8, 0.1)}, r"\(2 numbers\)"),
        ({"fractions": (0.8, 0.1, 0.2)}, "sum 1.1"),
        ({"fractions": (1.2, -0.1, -0.1)}, "none negative"),
        ({"fractions": (float("nan"), 0.5, 0.5)}, "sum nan"),
        ({"fractions": "most,some,few"}, "three numbers"),
        ({"force": (13, 1)}, "lowest < highest"),
        ({"force": (float("nan"), 1)}, "finite"),
        ({"force": "1-13"}, r"--force 1\.\.13"),
        ({"force": (0, float("inf"))}, "finite"),
        ({"force": (20, 30)}, "forces reach from 5 to 5 N"),
        ({"seed": 1.5}, "whole number"),
        ({"seed": True}, "whole number"),
        ({"hold_out": "sensor"}, "Name the kind"),
        ({"hold_out": ""}, "Name the kind"),
        ({"hold_out": "sensor="}, "Name the kind"),
        ({"hold_out": {}}, "names no unit"),
        ({"hold_out": {"sensor": [""]}}, "not empty"),
        ({"hold_out": "robot=ur5e"}, "'robot'"),
        ({"hold_out": "sensor=Q"}, "'Q'"),
        ({"hold_out": "sensor=A,B,C,D,E"}, "every one of 100 trajectories is held out"),
        ({"name": "../evil"}, "cannot be a file name"),
        ({"name": "a/b"}, "cannot be a file name"),
        ({"name": ""}, "cannot be a file name"),
        ({"name": "x" * 65}, "cannot be a file name"),
        ({"name": "default.normalisation"}, "cannot be a file name"),
        ({"name": None}, "cannot be a file name"),
    ],
    ids=repr,
)
def test_bad_options_are_refused_and_nothing_is_written(store, options, message):
    """Options that make no sense end in a clear error before anything is written."""
    with pytest.raises((UsageError, StoreError), match=message):
        make_split(store, **options)
    assert not (store.folder / "splits").exists()


@pytest.mark.parametrize(
    ("rows", "columns", "message"),
    [
        ([], {}, "no trajectories"),
        (many(1), {}, "the store has one trajectory; expected at least two"),
        ([*many(1), {"parent": f"{0:016x}"}], {}, "must stand together"),
        (many(4), {"contact_force": np.full(12, np.nan)}, "--force none"),
        (many(4), {"flags": np.full(12, FrameFlag.MISSING)}, "has a whole image"),
        (many(4), {"trajectory": np.full(12, 9)}, "trajectory row 9"),
        ([{"uid": "a"}, {"uid": "a"}, {"uid": "b"}], {}, "stands twice"),
        ([{"uid": "a", "parent": "b"}, {"uid": "b", "parent": "a"}, {"uid": "c"}], {}, "derived from itself"),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_stores_that_cannot_be_split(tmp_path, rows, columns, message):
    """Stores without anything to split, or damaged ones, say what is missing."""
    table = trajectories(rows)
    with pytest.raises(StoreError, match=message):
        make_split(MemoryStore(tmp_path, table, frames(table, **columns)))


def test_without_wrench_every_frame_can_be_taken(tmp_path):
    """--force none takes frames without a force."""
    table = trajectories(many(20))
    store = MemoryStore(tmp_path, table, frames(table, contact_force=np.full(60, np.nan)))
    report = make_split(store, force=None, hold_out="none")
    assert sum(count.frames for count in report.counts.values()) == 60


def test_a_store_far_away_is_not_split(store):
    """A store behind a URL is for reading."""
    store.split_path = lambda name, suffix=".parquet": f"https://example.org/ds.zarr/splits/{name}{suffix}"
    with pytest.raises(UsageError, match="not on a local disk"):
        make_split(store)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(28, "No space left on device"), "No space left on device; expected"),
        (OSError("odd"), "odd; expected"),
    ],
)
def test_a_folder_that_refuses_is_said(store, monkeypatch, error, words):
    """A full disk ends in an error that names the folder, and leaves no half file."""

    def refuse(path, content):
        raise error

    monkeypatch.setattr("tactiledata.splits.manifest.write_atomic", refuse)
    with pytest.raises(StoreError, match=f"splits cannot be written: {words}"):
        make_split(store)


@pytest.mark.parametrize(
    ("number", "words", "never"),
    [
        (errno.EROFS, "Read-only file system.*Copy the store", "room"),
        (errno.EACCES, "Permission denied.*Copy the store", "room"),
        (errno.EDQUOT, "Make room there", "Copy the store"),
        (errno.EIO, "Check the disk", "room"),
    ],
)
def test_the_remedy_fits_what_the_system_said(store, monkeypatch, number, words, never):
    """A read-only disk, no rights, a full disk and a broken one: each has its own remedy."""

    def refuse(path, content):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("tactiledata.splits.manifest.write_atomic", refuse)
    with pytest.raises(StoreError, match=words) as caught:
        make_split(store)
    assert never not in str(caught.value)


def test_what_stands_out_is_said_in_words(tmp_path):
    """Empty parts, strata with holes, unnamed units and orphans are named."""
    rows = [*many(5, "AB"), {"sensor": "", "source": 9}, {"parent": "f" * 16, "source": 10}]
    table = trajectories(rows)
    report = make_split(MemoryStore(tmp_path, table), hold_out="none")
    notes = "\n".join(report.notes)
    assert "got no trajectory" in notes
    assert "they would stand apart from the trajectories that they derive from" in notes
    assert "--seed" not in notes
    assert "trajectories that name no sensor: 1" in notes
    assert "1 parent trajectory that this store does not hold" in notes


def test_suggested_seeds_fill_every_part(tmp_path):
    """A seed that a note suggests leaves no part empty, also where `auto` has too few units to hold any out."""
    table = trajectories(many(8))
    store = MemoryStore(tmp_path, table)
    for seed in range(20):
        report = make_split(store, seed=seed, by="trajectory,indenter", replace=True)
        note = next((note for note in report.notes if "fills every part" in note), None)
        if note:
            good = int(re.search(r"--seed (\d+) --replace", note)[1])
            counts = make_split(store, seed=good, by="trajectory,indenter", replace=True).counts
            assert all(counts[part].trajectories for part in ("train", "val", "test"))
            return
    pytest.fail("no seed of 20 left a part of 8 trajectories empty")


def test_options_as_people_type_them():
    """The command line's texts are read as meant."""
    want = {"sensor": ("A", "B"), "indenter": ("x",)}
    assert read_hold_out("sensor=A,B;indenter=x") == want
    assert read_hold_out("sensor=B,indenter=x,sensor=A") == want
    assert read_hold_out("none") == "none"
    assert read_fractions("0.7,0.2,0.1") == (0.7, 0.2, 0.1)
    assert read_force("1..13") == (1.0, 13.0)
    assert read_force("none") is None
