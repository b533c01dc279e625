"""Which trajectories and frames go out, in which part, and what the page and the document say of them."""

import itertools
import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from copied_trees import copy_tree
from exported import expected_frames, export, nan_equal
from loader_stores import split_store, write_loader_store

from tactiledata.errors import LeakError, MissingSplit, UnknownName, UsageError
from tactiledata.export.find_episodes import UNSPLIT, find_episodes
from tactiledata.export.plan import ExportPlan
from tactiledata.loaders.selection import FlaggedTrajectoriesWarning
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import load_split
from tactiledata.store.read.reader import Store


def test_parts_hold_their_own_readable_frames(parted):
    """Episode after episode, the frames are those that a slow count finds, none twice, and the rest is counted."""
    episodes = find_episodes(parted, ExportPlan("huggingface", "default"))
    for part, (start, stop) in episodes.part_ranges().items():
        first, end = episodes.index.starts[[start, stop]]
        assert episodes.index.rows[first:end].tolist() == expected_frames(parted, part), part
    assert set(episodes.part_ranges()) == {"train", "val", "test"}
    assert episodes.left_out == {"no image recorded": 2, "image does not decode": 1}
    assert len(episodes.index.rows) + 3 == parted.n_frames


@pytest.mark.parametrize("frames", [1, 2, 64])
def test_batches_are_the_frames_in_order(frames, parted, monkeypatch):
    """Whatever the size of a batch, rows, values and the action at the next frame are those of the store."""
    monkeypatch.setattr("tactiledata.export.episodes.BATCH_FRAMES", frames)
    episodes = find_episodes(parted, ExportPlan("huggingface", "default", action="wrench"))
    rows, actions = [], []
    for batch in episodes.batches(0, len(episodes)):
        assert len(batch) <= frames
        assert nan_equal(batch.values["wrench"], parted.aligned("wrench", batch.rows)[0])
        assert [content for content, _, _ in batch.pictures] == parted.encoded(batch.rows)
        rows += batch.rows.tolist()
        actions.append(batch.values["action"])
    assert rows == episodes.index.rows.tolist()
    for episode in range(len(episodes)):
        start, stop = episodes.index.starts[episode : episode + 2]
        mine = episodes.index.rows[start:stop]
        following = [*mine[1:], mine[-1]]
        assert nan_equal(np.concatenate(actions)[start:stop], parted.aligned("wrench", following)[0])


def test_groups_keep_parts_apart(parted):
    """Ranges of episodes follow one another, hold no two parts, and end where their size is reached."""
    episodes = find_episodes(parted, ExportPlan("huggingface", "default"))
    for largest in (1, 3000, 10**9):
        groups = episodes.groups(largest)
        assert groups[0][0] == 0
        assert all(end == start for (_, end), (start, _) in itertools.pairwise(groups))
        assert groups[-1][1] == len(episodes)
        assert all(len({*episodes.parts[start:stop]}) == 1 for start, stop in groups)
    assert len(episodes.groups(1)) == len(episodes)
    assert len(episodes.groups(10**9)) == 3


def test_trajectories_of_the_split_that_are_not_there_are_counted(tiny_store, tmp_path):
    """An export says how many trajectories of the split it does not hold, as the split takes no frame of them."""
    place = copy_tree(tiny_store, tmp_path / "ds.zarr")
    store = Store.open(place)
    peaks = sorted(store.trajectories(["peak_force"])["peak_force"].to_pylist())
    make_split(store, name="firm", force=((peaks[0] + peaks[1]) / 2, 99.0), hold_out="none")
    split = load_split(Store.open(place), "firm").document["counts"]
    assert sum(counts["trajectories"] for counts in split.values()) == len(peaks)
    _, document = export(Store.open(place), "webdataset", tmp_path / "out", split="firm")
    there = {part: document["parts"].get(part, {"trajectories": 0})["trajectories"] for part in split}
    lacking = {part: counts["trajectories"] - there[part] for part, counts in split.items() if part != "excluded"}
    assert sum(lacking.values()) > 0
    [said] = [remark for remark in document["remarks"] if "not in this export" in remark]
    where = ", ".join(f"{part} {count}" for part, count in lacking.items() if count)
    assert said.startswith(f"{sum(lacking.values())} traject")
    assert f"not in this export ({where}): of " in said
    _, document = export(Store.open(place), "webdataset", tmp_path / "all")
    assert not [remark for remark in document["remarks"] if "not in this export" in remark]


@pytest.mark.slow
def test_without_a_split(tmp_path):
    """A store without a split is refused until it is said that none is wanted; one that is out of date, too."""
    store = write_loader_store(tmp_path / "ds.zarr", n_sources=2)
    with pytest.raises(MissingSplit, match="--split none"):
        export(store, "huggingface", tmp_path / "out")
    out, document = export(store, "huggingface", tmp_path / "out", split="none")
    assert document["parts"] == {UNSPLIT: {"trajectories": 6, "frames": 36, "in_split": 36}}
    assert document["split"] is None
    assert pq.read_table(out / "data").num_rows == 36
    parted = split_store(tmp_path / "more.zarr", n_sources=3)
    from loader_stores import _staged

    from tactiledata.store.read.reader import Store
    from tactiledata.store.write.commit import commit

    place = tmp_path / "more.zarr"
    commit(place, [_staged(place, 7, 3, "png", ("digit",), set())])
    assert parted.n_frames < Store.open(place).n_frames
    with pytest.raises(LeakError, match="out of date"):
        export(Store.open(place), "huggingface", tmp_path / "later")


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"camera": "nose"}, UnknownName, "digit"),
        ({"streams": ("wrench", "digit")}, UsageError, "no row of numbers"),
        ({"streams": ("pose",)}, UnknownName, "wrench"),
        ({"action": "tpc"}, UnknownName, "stream for the action"),
        ({"split": "nobody"}, UnknownName, "default"),
        ({"file_mb": 0}, UsageError, "from 1 to"),
    ],
)
def test_wrong_options_are_refused(options, error, words, parted, tmp_path):
    """Each is an error that says what there is, and nothing is left behind."""
    with pytest.raises(error, match=words):
        export(parted, "huggingface", tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_choices_of_frames_are_refused_for_whole_recordings(parted, tmp_path):
    """MCAP keeps whole recordings: a camera, streams or an action would be ignored, and are wrong usage instead."""
    for options in ({"camera": "digit"}, {"streams": ("wrench",)}, {"action": "none"}):
        with pytest.raises(UsageError, match="whole recordings"):
            export(parted, "mcap", tmp_path / "out", **options)


@pytest.mark.slow
def test_several_cameras_must_be_named(tmp_path):
    """Of two cameras one is named, and only its frames go out."""
    store = split_store(tmp_path / "ds.zarr", n_sources=4, cameras=("digit", "other"))
    with pytest.raises(UsageError, match="digit, other"):
        export(store, "huggingface", tmp_path / "out")
    _, document = export(store, "huggingface", tmp_path / "out", camera="other")
    assert document["left_out"] == {"of another camera": store.n_frames // 2}


def test_what_travels_along(tiny_store, tmp_path):
    """Split, units, frames, signs, simulated recordings and provenance stand in document, page and tables."""
    from tactiledata.store.read.reader import Store

    store = Store.open(tiny_store)
    out, document = export(store, "huggingface", tmp_path / "out")
    assert document["split"]["name"] == "default"
    assert document["simulated_recordings"] == {"simulated": 2, "real": 0, "not_stated": 0}
    wrench = document["streams"]["contact_wrench"]
    assert wrench["units"] == ["N"] * 3 + ["N m"] * 3
    assert wrench["frame"] == "gel"
    assert "pressing gives fz > 0" in wrench["meaning"]
    assert "pushes the gel along its -z, gravity included" in document["streams"]["wrench"]["meaning"]
    assert document["streams"]["tcp"]["frame"] == "base"
    assert document["provenance"]["inputs"]["store"] == store.digest
    page = (out / "README.md").read_text()
    assert "Simulated recordings: all 2 recordings." in page
    for sentence in (*document["lost"], *document["remarks"]):
        assert f"- {sentence}" in page
    touches = pq.read_table(out / "tactiledata" / "trajectories.parquet").to_pylist()
    assert [touch["recorded"] for touch in touches] == ["simulated"] * 4
    assert {touch["uid"] for touch in touches} == {*store.trajectories(["uid"])["uid"].to_pylist()}
    recordings = pq.read_table(out / "tactiledata" / "recordings.parquet").to_pylist()
    assert [json.loads(each["description"])["wrench"]["sign"] for each in recordings] == ["load_on_sensor"] * 2
    assert len(list((out / "tactiledata" / "backgrounds").iterdir())) == 2


@pytest.mark.slow
def test_nothing_is_called_simulated_where_it_is_not_stated(unstated, tmp_path):
    """Negative control: logs that do not state what they are make no export of simulated recordings."""
    from tactiledata.store.read.reader import Store

    out, document = export(Store.open(unstated), "huggingface", tmp_path / "out", split="none")
    assert document["simulated_recordings"] == {"simulated": 0, "real": 0, "not_stated": 2}
    assert "imulated recordings" not in (out / "README.md").read_text()


def test_flags_travel_along(tiny_store, tmp_path):
    """A trajectory that is flagged after the split goes out with its reason; with another flag it is another export."""
    from tactiledata.store.change.flag import flag_trajectories
    from tactiledata.store.read.reader import Store

    place = copy_tree(tiny_store, tmp_path / "ds.zarr")
    _, unflagged = export(Store.open(place), "huggingface", tmp_path / "before")
    assert not any("flagged" in remark for remark in unflagged["remarks"])
    uid = Store.open(place).trajectories(["uid"])["uid"][1].as_py()
    flag_trajectories(str(place), [uid], "the gel slipped")
    with pytest.warns(FlaggedTrajectoriesWarning):
        out, flagged = export(Store.open(place), "huggingface", tmp_path / "after")
    assert flagged["key"] != unflagged["key"]
    [remark] = [remark for remark in flagged["remarks"] if "flagged" in remark]
    assert remark.startswith("1 flagged trajectory went out as well (")
    assert "the gel slipped" in remark
    touches = pq.read_table(out / "tactiledata" / "trajectories.parquet").to_pylist()
    assert {touch["uid"]: touch["flag"] for touch in touches if touch["flag"]} == {uid: "the gel slipped"}
