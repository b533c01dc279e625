"""What LeRobot's own loader reads of an export is what the store holds."""

import json

import numpy as np
import pandas as pd
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
from exported import expected_frames, export, nan_equal
from loader_stores import split_store
from owner_loaders import run_program, snippet_of

from tactiledata.errors import UsageError
from tactiledata.export.find_episodes import find_episodes
from tactiledata.export.lerobot import frames_per_second
from tactiledata.export.plan import ExportPlan
from tactiledata.store.read.reader import Store

READ = """
import numpy as np
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.compute_stats import compute_episode_stats, aggregate_stats
dataset = LeRobotDataset("tactile", root=".")
meta = dataset.meta
items = [dataset[number] for number in range(len(dataset))]
names = [name for name, feature in meta.features.items() if feature["dtype"] != "image"]
camera = meta.camera_keys[0]
result = {
    "fps": meta.fps, "episodes": meta.total_episodes, "names": meta.names, "splits": meta.info["splits"],
    "rows": {name: [item[name].tolist() for item in items] for name in names},
    "sums": [int(round(float(item[camera].sum()) * 255)) for item in items],
    "shape": list(items[0][camera].shape), "tasks": [item["task"] for item in items],
    "trajectories": meta.episodes["trajectory"][:],
    "ours": {k: {n: v.tolist() for n, v in s.items()} for k, s in meta.stats.items()},
}
# LeRobot's own statistics of the same episodes; pictures it would read from files, so numbers only
numbers = {name: meta.features[name] for name in names if name not in ("in_split",)}
stats = []
for episode in range(meta.total_episodes):
    first, last = meta.episodes[episode]["dataset_from_index"], meta.episodes[episode]["dataset_to_index"]
    data = {name: np.array([result["rows"][name][row] for row in range(first, last)]) for name in numbers}
    stats.append(compute_episode_stats(data, numbers))
result["theirs"] = {k: {n: np.asarray(v).tolist() for n, v in s.items()} for k, s in aggregate_stats(stats).items()}
# windows of neighbouring frames, and batches as a training loop takes them
step = 1 / meta.fps
windows = LeRobotDataset("tactile", root=".", episodes=[1], delta_timestamps={"observation.wrench": [-step, 0.0, step]})
result["window"] = windows[0]["observation.wrench"].tolist()
result["is_pad"] = windows[0]["observation.wrench_is_pad"].tolist()
batch = next(iter(torch.utils.data.DataLoader(dataset, batch_size=4, shuffle=False)))
result["batch"] = list(batch[camera].shape)
"""


@pytest.mark.slow
def test_lerobot_reads_what_the_store_holds(owners, tmp_path):
    """Every row, number and picture, through `LeRobotDataset`, after the lines under Loading, run as they stand."""
    store = split_store(tmp_path / "ds.zarr", damaged=(3, 10))
    out, document = export(store, "lerobot", tmp_path / "out", action="wrench")
    read = run_program(snippet_of(out) + READ, out, tmp_path / "hf", owners)
    rows = [row for part in ("train", "val", "test") for row in expected_frames(store, part)]
    wrench = store.aligned("wrench", rows)[0].astype(np.float32)
    assert nan_equal(np.float32(read["rows"]["observation.wrench"]), wrench)
    assert read["rows"]["t_ns"] == store.frames(["t_ns"])["t_ns"].to_numpy()[rows].tolist()
    assert read["rows"]["index"] == list(range(len(rows)))
    pictures = np.asarray(store.images(rows))
    assert read["shape"] == [3, *pictures.shape[1:3]]
    assert read["sums"] == pictures.sum(axis=(1, 2, 3), dtype=int).tolist()
    assert read["names"]["observation.wrench"] == ["fx", "fy", "fz", "tx", "ty", "tz"]
    counts = document["parts"]
    train = counts["train"]["trajectories"]
    assert read["splits"]["train"] == f"0:{train}"
    assert read["splits"]["val"] == f"{train}:{train + counts['val']['trajectories']}"
    assert sorted(read["trajectories"]) == sorted(store.trajectories(["uid"])["uid"].to_pylist())
    assert set(read["tasks"]) == {"touch ball", "touch cone", "touch edge"}
    assert read["batch"] == [4, 3, *pictures.shape[1:3]]
    _windows_stay_inside(read)
    _statistics_agree(read)


def _windows_stay_inside(read):
    """At the first frame of an episode the window has no frame before it, which LeRobot marks as padding."""
    first = read["rows"]["episode_index"].index(1)
    wrench = read["rows"]["observation.wrench"]
    assert read["window"] == [wrench[first], wrench[first], wrench[first + 1]]
    assert read["is_pad"] == [True, False, False]


def _statistics_agree(read):
    """Mean, spread, extremes and count are LeRobot's own, and its quantiles, which it estimates, are near."""
    for feature, theirs in read["theirs"].items():
        ours = read["ours"][feature]
        for name in ("min", "max", "mean", "std", "count"):
            np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-5, atol=1e-6, err_msg=f"{feature} {name}")
        spread = np.subtract(theirs["max"], theirs["min"])
        for name in ("q01", "q50", "q99"):
            assert (np.abs(np.subtract(ours[name], theirs[name])) <= 0.35 * spread + 1e-6).all(), (feature, name)
    assert np.shape(read["ours"]["observation.images.digit"]["mean"]) == (3, 1, 1)


def test_the_layout_is_that_of_version_three(parted, tmp_path, monkeypatch):
    """Several files of data; every episode knows its file and its rows; statistics and info fit the rows."""
    monkeypatch.setattr("tactiledata.export.lerobot.MEGABYTE", 5000)
    monkeypatch.setattr("tactiledata.export.lerobot.EPISODES_A_FILE", 10)
    out, document = export(parted, "lerobot", tmp_path / "out", file_mb=1)
    info = json.loads((out / "meta" / "info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    assert info["features"]["observation.wrench"]["units"] == ["N", "N", "N", "N m", "N m", "N m"]
    episodes = pd.concat(pd.read_parquet(path) for path in sorted((out / "meta" / "episodes").rglob("*.parquet")))
    assert episodes["episode_index"].tolist() == list(range(info["total_episodes"]))
    assert episodes["meta/episodes/file_index"].nunique() == 3
    for row in episodes.to_dict("records"):
        chunk, file = row["data/chunk_index"], row["data/file_index"]
        table = pq.read_table(out / info["data_path"].format(chunk_index=chunk, file_index=file))
        mine = table.filter(pc.equal(table["episode_index"], row["episode_index"]))["index"].to_pylist()
        assert mine == list(range(row["dataset_from_index"], row["dataset_to_index"]))
    assert sum(name.startswith("data/") for name in document["files"]) > 3
    tasks = pd.read_parquet(out / "meta" / "tasks.parquet")
    assert tasks["task_index"].tolist() == list(range(len(tasks)))


def test_frames_per_second_and_uneven_steps(tiny_store, tmp_path):
    """The rate is the median step's; how many steps differ from it is said, and the true times are there."""
    store = Store.open(tiny_store)
    episodes = find_episodes(store, ExportPlan("lerobot", "default"))
    steps = [
        step
        for number in range(len(episodes))
        for step in np.diff(episodes.index.t_ns[slice(*episodes.index.starts[number : number + 2])])
    ]
    assert frames_per_second(episodes) == round(1e9 / np.median(steps))
    out, document = export(store, "lerobot", tmp_path / "out")
    info = json.loads((out / "meta" / "info.json").read_text())
    assert info["robot_type"] == "ur5e"
    assert info["features"]["observation.state"]["frame"] == "base"
    uneven = sum(abs(step * frames_per_second(episodes) / 1e9 - 1) > 0.1 for step in steps)
    assert any(f"{uneven} of {len(steps)} steps differ" in sentence for sentence in document["remarks"])


def test_pictures_of_several_sizes_are_refused(tmp_path):
    """LeRobot has one size a camera: an error counts the sizes, and nothing is written."""
    import loader_stores
    from loader_stores import _staged

    from tactiledata.store.write.commit import commit, create

    create(tmp_path / "ds.zarr")
    commit(tmp_path / "ds.zarr", [_staged(tmp_path / "ds.zarr", 0, 3, "png", ("digit",), set())])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loader_stores, "HEIGHT", 20)
        commit(tmp_path / "ds.zarr", [_staged(tmp_path / "ds.zarr", 1, 3, "png", ("digit",), set())])
    with pytest.raises(UsageError, match="several sizes"):
        export(Store.open(tmp_path / "ds.zarr"), "lerobot", tmp_path / "out", split="none")
    assert not (tmp_path / "out").exists()
