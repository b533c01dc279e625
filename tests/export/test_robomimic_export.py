"""What robomimic's own loader reads of an export is what the store holds."""

import h5py
import numpy as np
import pytest
from exported import expected_frames, export, nan_equal
from owner_loaders import run_program, snippet_of

READ = """
import json, numpy as np, h5py
keys = tuple(low_dim + rgb)
result = {}
for part in ("train", "valid", "test"):
    dataset = SequenceDataset("demonstrations.hdf5", keys, ("actions", "dones", "rewards"), filter_by_attribute=part)
    items = [dataset[number] for number in range(len(dataset))]
    result[part] = {
        "wrench": [item["obs"]["wrench"][0].tolist() for item in items],
        "next": [item["next_obs"]["wrench"][0].tolist() for item in items],
        "sums": [int(item["obs"]["digit_image"].sum()) for item in items],
        "next_sums": [int(item["next_obs"]["digit_image"].sum()) for item in items],
        "actions": [item["actions"][0].tolist() for item in items],
        "dones": [float(item["dones"][0]) for item in items],
    }
    dataset.close_and_delete_hdf5_handle()
windows = SequenceDataset("demonstrations.hdf5", keys, ("actions",), seq_length=3, hdf5_cache_mode="low_dim")
result["window"] = windows[0]["actions"].tolist()
windows.close_and_delete_hdf5_handle()
dataset = None
"""


def per_episode(store, part):
    """Rows of the frames of a part, a list for each trajectory."""
    trajectory = store.frames(["trajectory"])["trajectory"].to_numpy()
    rows = expected_frames(store, part)
    return [[row for row in rows if trajectory[row] == number] for number in dict.fromkeys(trajectory[rows].tolist())]


@pytest.mark.slow
def test_robomimic_reads_what_the_store_holds(owners, parted, tmp_path):
    """Every number and picture and the next ones, through `SequenceDataset`; filter keys are the parts."""
    out, document = export(parted, "robomimic", tmp_path / "out", action="wrench")
    read = run_program(snippet_of(out) + READ, out, tmp_path / "hf", owners)
    for key, part in (("train", "train"), ("valid", "val"), ("test", "test")):
        episodes = per_episode(parted, part)
        rows = [row for mine in episodes for row in mine]
        following = [row for mine in episodes for row in [*mine[1:], mine[-1]]]
        assert len(rows) == document["parts"][part]["frames"]
        for name, wanted in (("wrench", rows), ("next", following), ("actions", following)):
            assert nan_equal(read[key][name], parted.aligned("wrench", wanted)[0]), name
        for name, wanted in (("sums", rows), ("next_sums", following)):
            assert read[key][name] == np.asarray(parted.images(wanted)).sum(axis=(1, 2, 3), dtype=int).tolist(), name
        assert read[key]["dones"] == [float(row == mine[-1]) for mine in episodes for row in mine]
    assert np.shape(read["window"]) == (3, 6)


def test_the_file_without_robomimic(parted, tmp_path):
    """By h5py alone, as robomimic documents its files: demonstrations, filter keys, attributes, views that moved."""
    out, _ = export(parted, "robomimic", tmp_path / "out", action="wrench")
    moved = tmp_path / "moved.hdf5"
    (out / "demonstrations.hdf5").rename(moved)
    with h5py.File(moved) as made:
        demos = made["data"]
        assert sum(demo.attrs["num_samples"] for demo in demos.values()) == demos.attrs["total"]
        named = [name.decode() for key in made["mask"].values() for name in key[:]]
        assert sorted(named) == sorted(demos)
        assert set(made["mask"]) == {"train", "valid", "test"}
        assert demos["demo_0/obs/wrench"].attrs["units"] == "N N N N m N m N m"
        assert demos["demo_0/obs/wrench"].attrs["frame"] == "ft"
        for demo in demos.values():
            for name, values in demo["obs"].items():
                expected = np.concatenate([values[1:], values[-1:]])
                assert np.array_equal(demo[f"next_obs/{name}"][:], expected)
                assert demo[f"next_obs/{name}"].is_virtual


def test_without_an_action(parted, tmp_path):
    """A store without a pose has no action, and that is said; nothing is invented in its place."""
    out, document = export(parted, "robomimic", tmp_path / "out")
    with h5py.File(out / "demonstrations.hdf5") as made:
        assert "actions" not in made["data/demo_0"]
    assert any("There is no action" in sentence for sentence in document["remarks"])
