"""Stores transferred to another sensor: laws of the pictures, children that name their parents, kills, bad input."""

import hashlib
import json
import os
import signal

import numpy as np
import pyarrow as pa
import pytest
from copied_trees import copy_tree
from transfer_stores import MOMENTS, write_two_sensors

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from tactiledata.contract.take import Reference
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.sensors.backgrounds import load_background
from tactiledata.splits.across import audit_across
from tactiledata.splits.audit import audit, audit_tables
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import Split, load_split, read_split
from tactiledata.splits.options import EXCLUDED
from tactiledata.store.change.flag import flag_trajectories
from tactiledata.store.change.keep_sensors import keep_sensors
from tactiledata.store.change.merge import merge
from tactiledata.store.check.check import check
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import Target, find_target

SWAP = PIXEL_TRANSFERS["background_swap"]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A store of eight recordings on two sensors, small pictures."""
    return write_two_sensors(tmp_path_factory.mktemp("source") / "ds.zarr")


@pytest.fixture(scope="module")
def target():
    rng = np.random.default_rng(9)
    return Target("T1", rng.integers(60, 90, (16, 12, 3)).astype(np.uint8), "made", licence="CC0", model="gelsight_r15")


@pytest.fixture(scope="module")
def made(source, target, tmp_path_factory):
    """It transferred, not to be changed."""
    out = tmp_path_factory.mktemp("made") / "t1.zarr"
    transfer_store(source, target, SWAP, out)
    return Store.open(out)


@pytest.mark.slow
def test_every_touch_is_there_once(source, made):
    """Frames of trajectories with a whole picture are there in order, with the parents' times and forces."""
    rows = made.frame_values("parent_row")[:, 0].astype(int)
    frames = source.frames()
    expected = [
        row
        for row, (trajectory, flags) in enumerate(zip(*_lists(frames, "trajectory", "flags"), strict=True))
        if trajectory >= 0 and not flags & 3
    ]
    assert rows.tolist() == expected
    for column in ("t_ns", "camera", "contact_force", "header_ns"):
        assert made.frames()[column].to_pylist() == frames[column].take(pa.array(rows)).to_pylist()
    assert set(made.frames()["sensor"].to_pylist()) == {"T1"}
    assert check(made) == []


def test_pictures_are_the_methods(source, made, target):
    """Each new picture is what the method makes of the parent's, by its own sensor's background, lossless."""
    rows = made.frame_values("parent_row")[:, 0].astype(int)
    sensors = source.frames()["sensor"].to_pylist()
    for row, parent in list(enumerate(rows))[::5]:
        background = source.reference(sensors[parent]).image
        expected = SWAP.transfer(np.asarray(source.images([parent])), background, target.background)[0]
        np.testing.assert_array_equal(np.asarray(made.images([row]))[0], expected)


def test_signals_and_aligned_values_are_the_parents(source, made):
    """Forces at native rate and at the frames are those of the recordings."""
    rows = made.frame_values("parent_row")[:, 0].astype(int)
    for ours, theirs in zip(made.aligned("wrench"), source.aligned("wrench", rows), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    native = made.signal("wrench")
    parents = {row["uid"]: row for row in source.trajectories().to_pylist()}
    for row in made.trajectories().to_pylist():
        ranges, wanted = json.loads(row["signal_rows"]), json.loads(parents[row["parent"]]["signal_rows"])
        assert ranges.keys() == wanted.keys()
        for name in ranges:
            np.testing.assert_array_equal(native.values(*ranges[name]), source.signal(name).values(*wanted[name]))


def test_trajectories_are_children(source, made):
    """Each trajectory has a uid of its own, names its parent, its method and the sensor that really felt it."""
    parents = {row["uid"]: row for row in source.trajectories().to_pylist()}
    children = made.trajectories().to_pylist()
    assert len(children) == len(parents)
    assert not {row["uid"] for row in children} & set(parents)
    for row in children:
        parent = parents[row["parent"]]
        extra = json.loads(row["extra"])
        assert (row["sensor"], extra["parent_sensor"], extra["transfer"]) == (
            "T1",
            parent["sensor"],
            "background_swap",
        )
        assert (row["indenter"], row["start_ns"]) == (parent["indenter"], parent["start_ns"])


def test_target_is_a_sensor_of_the_store(made, target):
    """The store knows the target with its background, licence and where it is from; provenance says the method."""
    reference = made.reference("T1")
    np.testing.assert_array_equal(reference.image, target.background)
    assert (reference.origin, reference.licence) == ("made", "CC0")
    settings = json.loads(made.sources()["provenance"][0].as_py())["settings"]
    assert (settings["method"], settings["target"]) == ("background_swap", "T1")


@pytest.mark.slow
def test_to_itself_changes_nothing(source, tmp_path):
    """A sensor transferred to itself gives its own pictures back."""
    out = tmp_path / "same.zarr"
    own = find_target("D1", source)
    transfer_store(source, own, SWAP, out, sensors=["D1"])
    made = Store.open(out)
    rows = made.frame_values("parent_row")[:, 0].astype(int)
    np.testing.assert_array_equal(made.images(range(made.n_frames)), source.images(rows))


@pytest.mark.slow
def test_batch_borders_do_not_show(source, target, made, tmp_path, monkeypatch):
    """Another number of pictures in memory gives the same bytes."""
    monkeypatch.setattr("split_models.transfer.transfer_take.BATCH", 5)
    transfer_store(source, target, SWAP, tmp_path / "t1.zarr")
    assert Store.open(tmp_path / "t1.zarr").digest == made.digest
    assert Store.open(tmp_path / "t1.zarr").encoded(range(made.n_frames)) == made.encoded(range(made.n_frames))


def _lists(table, *names):
    return [table[name].to_pylist() for name in names]


def _parts(store):
    """Partition of each trajectory, by uid."""
    return dict(zip(*_lists(load_split(store, "default").table, "uid", "partition"), strict=True))


# -- families ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def both(source, made, tmp_path_factory):
    """Parents and children in one store, with a split that holds sensor D2 out."""
    place = tmp_path_factory.mktemp("both") / "both.zarr"
    merge([source, made], place)
    make_split(Store.open(place), fractions=(0.5, 0.25, 0.25), hold_out={"sensor": ["D2"]})
    return Store.open(place)


@pytest.mark.slow
def test_children_stand_with_their_parents(both):
    """In the merged store every child is in its parent's part, also of a held-out sensor; the audit is clean."""
    part = _parts(both)
    children = [row for row in both.trajectories().to_pylist() if row["parent"]]
    assert children
    assert {part[row["uid"]] for row in children} >= {"train", "test_unseen"}
    for row in children:
        assert part[row["uid"]] == part[row["parent"]]
    assert audit(both, images=False).leaks == ()


@pytest.mark.slow
def test_a_child_away_from_its_parent_is_caught(both):
    """A split whose table parts one child from its parent is found by the audit, and named."""
    split = read_split(both, "default")
    rows = split.table.to_pylist()
    parent_of = {row["uid"]: row["parent"] for row in both.trajectories().to_pylist()}
    child = next(row for row in rows if parent_of[row["uid"]] and row["partition"] == "train")
    child["partition"] = "test"
    doctored = Split("default", pa.Table.from_pylist(rows, split.table.schema), split.document)
    found = audit_tables(doctored, both.trajectories(), both.frames())
    assert "derived-away-from-parent" in {finding.code for finding in found if finding.severity == "damage"}


def test_a_store_of_children_alone_is_drawn_as_its_parents(source, made, tmp_path):
    """Split alone with the same seed, children go where their parents go in the other store."""
    options = {"fractions": (0.5, 0.25, 0.25), "hold_out": "none"}
    copies = {}
    for name, store in (("parents", source), ("children", made)):
        copy_tree(store.location, tmp_path / name)
        copies[name] = Store.open(tmp_path / name)
        make_split(copies[name], **options)
    parts = {name: _parts(store) for name, store in copies.items()}
    for row in made.trajectories().to_pylist():
        assert parts["children"][row["uid"]] == parts["parents"][row["parent"]]


@pytest.mark.slow
def test_children_of_flagged_parents_are_flagged(source, target, tmp_path):
    """A transfer carries flags along: the child of a flagged parent is out of splits, in its own store and merged; a
    parent that is flagged later is found by the audit of both stores, and carried by running the transfer again.
    """
    parents, out = tmp_path / "p.zarr", tmp_path / "t1.zarr"
    copy_tree(source.location, parents)
    first, later = _lists(source.trajectories(), "uid")[0][:2]
    flag_trajectories(parents, [first], "slipped")
    report = transfer_store(Store.open(parents), target, SWAP, out)
    assert [finding.code for finding in report.findings if finding.code.startswith("flag")] == ["flags-carried"]
    child_of = {row["parent"]: row["uid"] for row in Store.open(out).trajectories().to_pylist()}
    assert {uid: flag.origin for uid, flag in flagged_trajectories(Store.open(out)).items()} == {child_of[first]: first}
    for place in (parents, out):
        make_split(Store.open(place), fractions=(0.5, 0.25, 0.25), hold_out="none")
    assert _parts(Store.open(out))[child_of[first]] == EXCLUDED
    merge([parents, out], tmp_path / "both.zarr")
    assert set(flagged_trajectories(Store.open(tmp_path / "both.zarr"))) == {first, child_of[first]}
    # flagged after the transfer
    assert audit_across(Store.open(out), Store.open(parents)) == []
    flag_trajectories(parents, [later], "too late")
    (found,) = audit_across(Store.open(out), Store.open(parents))
    assert (found.code, found.severity, "too late" in found.message) == ("flagged-in-split", "damage", True)
    transfer_store(Store.open(parents), target, SWAP, out)
    assert set(flagged_trajectories(Store.open(out))) == {child_of[first], child_of[later]}
    assert audit_across(Store.open(out), Store.open(parents)) == []


# -- killed, run again -------------------------------------------------------------------------------------------------


def files(folder):
    return {
        str(place.relative_to(folder)): hashlib.sha256(place.read_bytes()).hexdigest()
        for place in sorted(folder.rglob("*"))
        if place.is_file() and place.name not in (".lock", ".intake.lock")
    }


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_killed_and_run_again_gives_the_same_bytes(target, tmp_path, seed, monkeypatch):
    """SIGKILL at random calls that change the disk, then left alone: every file as without a kill."""
    monkeypatch.setattr("tactiledata.store.write.commit.GROUP_TAKES", 2)
    source = write_two_sensors(tmp_path / "ds.zarr", n_sources=4)
    whole, killed = tmp_path / "whole.zarr", tmp_path / "killed.zarr"
    transfer_store(source, target, SWAP, whole)
    rng = np.random.default_rng(seed)
    kills = 0
    for _ in range(3):
        moment = int(rng.integers(20, 160))
        child = os.fork()
        if child == 0:
            try:
                die_at(moment)
                transfer_store(source, target, SWAP, killed)
            finally:
                os._exit(0)
        kills += os.WIFSIGNALED(os.waitpid(child, 0)[1])
    assert kills
    transfer_store(source, target, SWAP, killed)
    assert files(killed) == files(whole)


def die_at(moment):
    """End this process by SIGKILL at the n-th call that changes the disk."""
    left = [moment]

    def counted(call):
        def run(*arguments, **options):
            left[0] -= 1
            if left[0] < 0:
                os.kill(os.getpid(), signal.SIGKILL)
            return call(*arguments, **options)

        return run

    for name in MOMENTS:
        setattr(os, name, counted(getattr(os, name)))


@pytest.mark.slow
def test_again_adds_nothing_and_new_recordings_are_added(source, target, tmp_path):
    """The same call twice is no change; recordings that came to the source are added, the others stay."""
    fewer = write_two_sensors(tmp_path / "fewer.zarr", n_sources=3)
    out = tmp_path / "out.zarr"
    first = transfer_store(fewer, target, SWAP, out)
    again = transfer_store(fewer, target, SWAP, out)
    more = transfer_store(source, target, SWAP, out)
    assert (first.added, again.added, more.added) == (3, 0, 5)
    assert again.frames == first.frames
    assert more.recordings == 8


# -- bad input ---------------------------------------------------------------------------------------------------------


def test_another_method_into_the_same_store_is_refused(source, target, made, tmp_path):
    """Another method, another background or other sensors do not mix in one store; nor do recordings."""
    out = tmp_path / "t1.zarr"
    copy_tree(made.location, out)
    before = files(out)
    brighter = Target("T1", target.background + np.uint8(1), "made", model="gelsight_r15")
    for method, goal in ((PIXEL_TRANSFERS["reinhard"], target), (SWAP, brighter)):
        with pytest.raises(UsageError, match="with other settings than now"):
            transfer_store(source, goal, method, out)
    copy_tree(source.location, tmp_path / "recorded.zarr")
    with pytest.raises(UsageError, match="holds the recording run0"):
        transfer_store(source, target, SWAP, tmp_path / "recorded.zarr")
    with pytest.raises(UsageError, match="into itself"):
        transfer_store(source, target, SWAP, tmp_path.parent / source.location)
    assert files(out) == before


def test_other_sizes_are_refused_before_anything_is_written(source, tmp_path):
    """A target of another size names both sizes and the sensor."""
    other = Target("T2", np.zeros((12, 16, 3), np.uint8), "made", model="gelsight_r15")
    with pytest.raises(UsageError, match="12 rows x 16 columns, that of D1 16 x 12"):
        transfer_store(source, other, SWAP, tmp_path / "out.zarr")
    assert not (tmp_path / "out.zarr").exists()


def test_swapped_channels_of_the_target_are_refused(source, tmp_path):
    """A DIGIT's background with red and blue swapped is found before its size matters."""
    swapped = np.ascontiguousarray(load_background("digit-bg-2")[..., ::-1])
    with pytest.raises(UsageError, match="red and blue"):
        transfer_store(source, Target("T3", swapped, "made"), SWAP, tmp_path / "out.zarr")


@pytest.mark.slow
def test_sensors_are_named_or_known(source, target, tmp_path):
    """An unknown source sensor lists those that there are; one without a background says how to add it."""
    with pytest.raises(UnknownName, match="one of: D1, D2"):
        transfer_store(source, target, SWAP, tmp_path / "out.zarr", sensors=["D3"])
    bare = write_two_sensors(tmp_path / "bare.zarr", n_sources=2, with_backgrounds=("D1",))
    with pytest.raises(StoreError, match=r"without a picture without contact: D2.*sensors add D2"):
        transfer_store(bare, target, SWAP, tmp_path / "out.zarr")
    report = transfer_store(bare, target, SWAP, tmp_path / "out.zarr", sensors=["D1"])
    assert report.sensors == ("D1",)
    keep_sensors(tmp_path / "bare.zarr", {}, {"D2": Reference(np.zeros((9, 9, 3), np.uint8), "made")})
    with pytest.raises(UsageError, match="that of D2 9 x 9"):
        transfer_store(Store.open(tmp_path / "bare.zarr"), target, SWAP, tmp_path / "other.zarr")


def test_a_store_without_whole_pictures_is_said_so(target, tmp_path):
    """Nothing to transfer is the data's fault, and named."""
    empty = write_two_sensors(tmp_path / "empty.zarr", n_sources=1, damaged=range(18))
    with pytest.raises(StoreError, match=r"no frame of .* can be transferred"):
        transfer_store(empty, target, SWAP, tmp_path / "out.zarr")
    assert not (tmp_path / "out.zarr").exists()


@pytest.mark.parametrize("path", ["sensors.json", "signals/wrench/value/zarr.json", "signals/wrench/value/c.0.0"])
def test_damage_is_not_carried_on(source, target, tmp_path, path):
    """Facts, attributes or numbers that were changed or lost would get checksums that fit in the store that is made."""
    folder = tmp_path / "ds.zarr"
    copy_tree(source.location, folder)
    place = folder / path
    if place.suffix == ".json":
        place.write_bytes(place.read_bytes().replace(b"e", b"a", 1))
    else:
        place.unlink()
    # facts of sensors are refused as soon as they are read, the others when the store is checked
    with pytest.raises(StoreError, match=r"is damaged|are not those that were written"):
        transfer_store(Store.open(folder), target, SWAP, tmp_path / "out.zarr")


@pytest.mark.slow
def test_few_pictures_are_in_memory(source, target, tmp_path, monkeypatch):
    """However many frames a recording has, no more than a batch of pictures is read at once."""
    asked = []
    read = Store.images
    monkeypatch.setattr(Store, "images", lambda self, rows, *more: asked.append(len(rows)) or read(self, rows, *more))
    monkeypatch.setattr("split_models.transfer.transfer_take.BATCH", 4)
    transfer_store(source, target, SWAP, tmp_path / "out.zarr")
    assert max(asked) == 4
    assert sum(asked) == Store.open(tmp_path / "out.zarr").n_frames
