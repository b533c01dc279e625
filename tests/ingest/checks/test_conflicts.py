"""What a recording contradicts in its store is said when it is ingested, not only kept."""

import pytest
from copied_trees import copy_tree

from tactiledata.ingest.checks.conflicts import CONFLICTS
from tactiledata.ingest.pipeline import ingest


def conflicts(report):
    return [(one.code, one.stream) for source in report.sources for one in source.findings if one.code in CONFLICTS]


def relabelled(log, place, name, other):
    """A copy of a folder log whose sensor goes by the serial of another one."""
    copy_tree(log, place)
    for table in ("log.yaml", "trajectories.csv"):
        (place / table).write_text((place / table).read_text().replace(name, other))
    (place / "backgrounds" / f"{name}.png").rename(place / "backgrounds" / f"{other}.png")
    return place


@pytest.mark.slow
def test_swapped_sensors_are_said(tiny_folders, tmp_path):
    """Under the serial of another sensor comes another picture without contact; true labels say nothing."""
    first, second = tiny_folders
    swapped = relabelled(first, tmp_path / "swapped", first.name, second.name)
    assert conflicts(ingest(tiny_folders, tmp_path / "ds.zarr")) == []
    assert conflicts(ingest([swapped], tmp_path / "ds.zarr")) == [("sensor-conflict", second.name)]
    assert conflicts(ingest([swapped], tmp_path / "ds.zarr")) == []


@pytest.mark.slow
def test_a_signal_that_means_something_else_is_said_once(tiny_folders, tmp_path):
    """The wrench in another frame is kept apart, with a word about it and none for its values at the frames."""
    other = copy_tree(tiny_folders[1], tmp_path / "other")
    text = (other / "log.yaml").read_text()
    (other / "log.yaml").write_text(text.replace("robotiq_ft_frame_id", "bench"))
    report = ingest([tiny_folders[0], other], tmp_path / "ds.zarr")
    assert conflicts(report) == [("signal-variant", "wrench")]
