"""Frames and trajectories as arrays: what is read is what was stored, of one part of a split, nothing lost unsaid."""

import json
import pickle
import subprocess
import sys

import loader_stores as made
import numpy as np
import pytest

from tactiledata.errors import LeakError, MissingFile, MissingSplit, StoreError, UnknownName, UsageError
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.splits.manifest import frame_rows, load_split
from tactiledata.store.layout.manifest import write_manifest

ALL_STREAMS = ("digit", "wrench", "background", "centre")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A store with a split, eight of its frames damaged."""
    folder = tmp_path_factory.mktemp("arrays") / "ds.zarr"
    made.split_store(folder, damaged=(1, 2, 9, 10, 20, 39, 50, 75))
    return folder


@pytest.mark.slow
def test_importing_loaders_imports_no_torch():
    """`tactiledata.loaders` and its numpy half work where torch is not installed."""
    code = (
        "import sys; sys.modules['torch'] = None; import tactiledata.loaders, tactiledata.loaders.numpy, "
        "tactiledata.loaders.order"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["png", "raw"])
def test_frames_are_those_that_were_stored(tmp_path, encoding):
    """Pictures, values, times, sensors and backgrounds of every frame come back exactly, in any order."""
    store = made.split_store(tmp_path / "ds.zarr", encoding=encoding)
    arrays = TactileArrays(store.location, "default/train", ALL_STREAMS, image_dtype="uint8")
    numbers = np.random.default_rng(0).permutation(len(arrays))
    batch = arrays.batch(numbers)
    rows = batch["frame"]
    np.testing.assert_array_equal(np.sort(rows), frame_rows(store, load_split(store, "default"), "train"))
    np.testing.assert_array_equal(batch["digit"], [made.picture(row) for row in rows])
    np.testing.assert_allclose(batch["wrench"], [made.force_at(row) for row in rows], rtol=1e-6)
    np.testing.assert_array_equal(batch["centre"], rows[:, None] * [1.0, 2.0])
    np.testing.assert_array_equal(batch["background"], [made.reference(sensor) for sensor in batch["sensor"]])
    np.testing.assert_array_equal(batch["t_ns"], store.frames(["t_ns"])["t_ns"].to_numpy()[rows])
    assert batch["sensor"] == store.frames(["sensor"])["sensor"].take(rows).to_pylist()


@pytest.mark.slow
def test_parts_hold_every_frame_once(place):
    """Train, val and test share no frame and no trajectory; together they are what the split takes."""
    parts = [TactileArrays(place, f"default/{part}", "digit") for part in ("train", "val", "test")]
    rows = np.concatenate([part.index.rows for part in parts])
    uids = [uid for part in parts for uid in set(part.batch(range(len(part)))["trajectory"])]
    assert len(set(rows.tolist())) == len(rows)
    assert len(set(uids)) == len(uids)
    assert len(rows) == sum(part.report.frames for part in parts)


def test_what_is_left_out_is_said(place):
    """Held and left-out frames add up to all frames of the part's trajectories, and no damaged frame is held."""
    damaged = {1, 2, 9, 10, 20, 39, 50, 75}
    total, whole = 0, 0
    for part in ("train", "val", "test"):
        report = TactileArrays(place, f"default/{part}", "digit").report
        total += report.frames + sum(report.left_out.values())
        whole += sum(report.left_out.get(reason, 0) for reason in ("no image recorded", "image does not decode"))
        assert not damaged & set(TactileArrays(place, f"default/{part}", "digit").index.rows.tolist())
        assert json.dumps(report.document())
        assert f"{report.frames} frames" in str(report)
    assert total == 8 * 3 * made.FRAMES
    assert whole == len(damaged)


def test_trajectories_have_all_their_readable_frames(place):
    """A trajectory's item has its frames in time order, free air included, and the samples of its own signal rows."""
    arrays = TactileArrays(place, "default/train", ALL_STREAMS, unit="trajectory", missing="keep", image_dtype="uint8")
    frames = TactileArrays(place, "default/train", "digit")
    store = arrays.store
    table = store.trajectories().to_pylist()
    taken = []
    for item in arrays:
        facts = next(row for row in table if row["uid"] == item["trajectory"])
        readable = [
            row for row in range(facts["frame_start"], facts["frame_stop"]) if row not in (1, 2, 9, 10, 20, 39, 50, 75)
        ]
        assert item["frame"].tolist() == readable
        np.testing.assert_array_equal(item["digit"], [made.picture(row) for row in readable])
        start, stop = json.loads(facts["signal_rows"]).get("wrench", (0, 0))
        np.testing.assert_array_equal(item["wrench"], store.signal("wrench").values(start, stop).astype(np.float32))
        np.testing.assert_array_equal(item["wrench_t_ns"], store.signal("wrench").t_ns(start, stop))
        assert (item["sensor"], item["indenter"]) == (facts["sensor"], facts["indenter"])
        taken += item["frame"][item["in_split"]].tolist()
    assert sorted(taken) == frames.index.rows.tolist()
    assert len(arrays) == frames.report.trajectories


def test_float_pictures_are_bytes_over_255(place):
    """float32 pictures lie in [0, 1] and are the bytes divided by 255."""
    bytes_, floats = (
        TactileArrays(place, "default/val", "digit", image_dtype=kind).batch([0, 1])["digit"]
        for kind in ("uint8", "float32")
    )
    np.testing.assert_allclose(floats, bytes_ / 255.0, atol=1e-7)
    assert floats.dtype == np.float32


def test_batches_visit_every_item_once_in_a_seeded_order(place):
    """An epoch of batches has every frame once; the same seed gives the same order, another one another."""
    arrays = TactileArrays(place, "default/train", "centre")
    epochs = [np.concatenate([batch["frame"] for batch in arrays.batches(7, seed=seed)]) for seed in (1, 1, 2)]
    assert sorted(epochs[0].tolist()) == arrays.index.rows.tolist()
    assert epochs[0].tolist() == epochs[1].tolist() != epochs[2].tolist()
    trajectories = TactileArrays(place, "default/train", "centre", unit="trajectory")
    assert sum(len(batch) for batch in trajectories.batches(3)) == len(trajectories)


def test_batch_order_does_not_change_items(place):
    """An item is the same alone, in a batch, reversed and after pickling."""
    arrays = TactileArrays(place, "default/train", ALL_STREAMS, normalise=True)
    alone = [arrays[number] for number in (0, 5, 3)]
    again = pickle.loads(pickle.dumps(arrays))
    for items in (arrays.items([0, 5, 3]), again.items([3, 5, 0])[::-1]):
        for one, other in zip(alone, items, strict=True):
            assert one.keys() == other.keys()
            for name in one:
                np.testing.assert_array_equal(one[name], other[name])
    np.testing.assert_array_equal(arrays[-1]["frame"], arrays[len(arrays) - 1]["frame"])
    with pytest.raises(IndexError):
        arrays[len(arrays)]


@pytest.mark.parametrize("unit", ["frame", "trajectory"])
def test_free_columns_stand_beside_the_items(place, unit):
    """The table has a row for each item, in order, and the free columns that the recordings gave that trajectory."""
    arrays = TactileArrays(place, "default/train", "centre", unit=unit)
    store = arrays.store
    given = {row["uid"]: json.loads(row["extra"]) for row in store.trajectories(["uid", "extra"]).to_pylist()}
    rows = arrays.table().to_pylist()
    assert len(rows) == len(arrays)
    for row, item in zip(rows, arrays, strict=True):
        assert row["frame"] == np.atleast_1d(item["frame"])[0]
        assert all(row[name] == item[name] for name in ("trajectory", "sensor", "indenter"))
        assert row["extra.speed"] == given[row["trajectory"]]["speed"]
        assert row["extra.glue"] == str(given[row["trajectory"]]["glue"])


@pytest.mark.parametrize("split", [None, "", "default", "train", "default/", "/train", "default/trian", "other/train"])
def test_a_missing_split_is_an_error_that_lists_splits(place, split):
    """Without a part of a split there is no dataset; the message names splits, parts and the command."""
    with pytest.raises(MissingSplit) as caught:
        TactileArrays(place, split, "digit")
    text = str(caught.value)
    assert all(word in text for word in ("default", "train", "val", "test_unseen", "tactiledata split"))


def test_all_frames_only_where_leaks_are_allowed(place):
    """`split="all"` is refused unless it is said that leaks are allowed, and cannot be normalised."""
    with pytest.raises(UsageError, match="allow_leaks"):
        TactileArrays(place, "all", "digit")
    everything = TactileArrays(place, "all", "digit", allow_leaks=True)
    assert len(everything) == 8 * 3 * made.FRAMES - 8
    with pytest.raises(UsageError, match="normalise"):
        TactileArrays(place, "all", "wrench", allow_leaks=True, normalise=True)
    with pytest.raises(MissingSplit):
        TactileArrays(place, None, "digit", allow_leaks=True)


@pytest.mark.parametrize(
    ("options", "error", "word"),
    [
        ({"streams": ("digti",)}, UnknownName, "Did you mean digit"),
        ({"streams": ("digit", "mesh")}, StoreError, "replay"),
        ({"streams": ()}, UsageError, "at least one"),
        ({"streams": ("digit", "digit")}, UsageError, "each once"),
        ({"streams": ("sensor",)}, UsageError, "Every item"),
        ({"streams": None}, UsageError, "names of streams"),
        ({"streams": ("digit", 3)}, UsageError, "names of streams"),
        ({"threads": 0}, UsageError, "at least 1"),
        ({"unit": "frames"}, UnknownName, "Did you mean frame"),
        ({"image_dtype": "float16"}, UnknownName, "float32"),
        ({"normalise": "wrenhc"}, UnknownName, "wrench"),
        ({"normalise": ["digit"], "image_dtype": "uint8"}, UsageError, "float32"),
    ],
)
def test_wrong_options_say_what_is_right(place, options, error, word):
    """Unknown streams, units and types, and combinations that make no sense, are refused with a way out."""
    with pytest.raises(error, match=word):
        TactileArrays(place, "default/train", **{"streams": ("digit", "wrench"), **options})


def test_frames_and_trajectories_are_not_mixed_up(place):
    """Asking a dataset of frames for trajectories, or the other way round, is refused."""
    with pytest.raises(UsageError):
        TactileArrays(place, "default/train", "digit", unit="trajectory").batch([0])
    with pytest.raises(UsageError):
        TactileArrays(place, "default/train", "digit").read_trajectories([0])


@pytest.mark.slow
def test_a_store_that_grew_needs_its_split_again(tmp_path):
    """Trajectories that a split does not know are an error, not silently left out."""
    made.split_store(tmp_path / "ds.zarr", n_sources=4)
    made.write_loader_store(tmp_path / "ds.zarr", n_sources=6)
    with pytest.raises(LeakError, match="out of date"):
        TactileArrays(tmp_path / "ds.zarr", "default/train", "digit")


def test_a_part_without_frames_is_an_error(place):
    """An empty part is said to be empty instead of training on nothing."""
    for unit in ("frame", "trajectory"):
        with pytest.raises(UsageError, match="default/test_unseen: 0 frames of 0 trajectories"):
            TactileArrays(place, "default/test_unseen", "digit", unit=unit)


def test_no_store_is_an_error(tmp_path):
    """A place without a store is named."""
    with pytest.raises(MissingFile, match="nowhere"):
        TactileArrays(tmp_path / "nowhere.zarr", "default/train")


@pytest.mark.slow
def test_one_camera_at_a_time(tmp_path):
    """Of a store with two cameras, the frames of the one that is asked for are held, the others are counted."""
    made.split_store(tmp_path / "ds.zarr", cameras=("left", "right"))
    left, right = (TactileArrays(tmp_path / "ds.zarr", "default/train", camera) for camera in ("left", "right"))
    assert not set(left.index.rows.tolist()) & set(right.index.rows.tolist())
    assert left.report.left_out["of another camera"] >= len(right)
    with pytest.raises(UsageError, match="at most one"):
        TactileArrays(tmp_path / "ds.zarr", "default/train", ("left", "right"))


@pytest.mark.slow
def test_a_sensor_without_background_is_named(tmp_path, monkeypatch):
    """A background is never made up: sensors without one are listed."""
    monkeypatch.setattr(made, "reference", lambda sensor: np.zeros((4, 4, 3), np.uint8))
    store = made.split_store(tmp_path / "ds.zarr")
    arrays = TactileArrays(store.location, "default/train", "background", image_dtype="uint8")
    assert arrays.batch([0])["background"].shape == (1, 4, 4, 3)
    manifest = json.loads((tmp_path / "ds.zarr" / "manifest.json").read_text())
    del manifest["references"]["D1"]
    write_manifest(tmp_path / "ds.zarr", manifest)
    with pytest.raises(StoreError, match=r"D1.*sensors add"):
        TactileArrays(tmp_path / "ds.zarr", "default/train", "background")


def test_reading_by_url(place):
    """A store behind a URL gives the same batch as the local one."""
    local = TactileArrays(place, "default/train", ALL_STREAMS, normalise=True)
    remote = TactileArrays(f"file://{place}", "default/train", ALL_STREAMS, normalise=True)
    for name, value in local.batch([0, 1]).items():
        np.testing.assert_array_equal(value, remote.batch([0, 1])[name])
    assert local.fingerprint == remote.fingerprint
