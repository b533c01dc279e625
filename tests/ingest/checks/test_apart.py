"""Streams of a recording that do not belong together are said; sound recordings say nothing of the kind."""

import csv
import shutil

import pytest
from copied_trees import copy_tree

from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions

CODES = {
    "signal-elsewhere",
    "signal-incomplete",
    "clock-apart",
    "images-of-another-sensor",
    "camera-stuck",
    "no-free-air",
}


def said(log, place, **options):
    [report] = ingest([log], place / "ds.zarr", **options).sources
    return {(one.code, one.stream) for one in report.findings if one.code in CODES}


def test_sound_recordings_say_nothing(tiny_folders, tmp_path):
    """A sound recording has no finding on streams that do not belong together."""
    assert said(tiny_folders[0], tmp_path) == set()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda t: t + 3600 * 10**9, "clock-apart"),
        (lambda t: t - 3600 * 10**9, "clock-apart"),
        (lambda t: t // 1000, "signal-elsewhere"),
    ],
)
def test_a_force_sensor_on_another_clock(tiny_folders, tmp_path, change, code):
    """Off by a time zone, or in microseconds: no touch has a force, which is said as that and as nothing else."""
    log = copy_tree(tiny_folders[0], tmp_path / "log")
    head, *rows = csv.reader((log / "wrench.csv").read_text().splitlines())
    lines = [",".join(head), *(",".join([str(change(int(row[0]))), *row[1:]]) for row in rows)]
    (log / "wrench.csv").write_text("\n".join(lines) + "\n")
    assert said(log, tmp_path) == {(code, "wrench")}


@pytest.mark.slow
@pytest.mark.parametrize(("stream", "also"), [("wrench", set()), ("tcp", {("no-free-air", "wrench")})])
def test_a_recorder_that_stopped(tiny_folders, tmp_path, stream, also):
    """A table that ends, line by line whole, in the middle of the recording; without poses no weight is taken off."""
    log = copy_tree(tiny_folders[0], tmp_path / "log")
    lines = (log / f"{stream}.csv").read_text().splitlines(keepends=True)
    (log / f"{stream}.csv").write_text("".join(lines[: len(lines) // 2]))
    assert said(log, tmp_path) == {("signal-incomplete", stream), *also}


@pytest.mark.slow
def test_images_under_another_serial(tiny_mcaps, tmp_path):
    """A mapping that names another sensor than the trajectories leaves them without images."""
    topic = f"/digit/{tiny_mcaps[0].stem}/image_raw/compressed"
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": topic, "sensor": "D99"}}}
    assert said(tiny_mcaps[0], tmp_path, options=IngestOptions(mapping=mapping)) == {("images-of-another-sensor", "")}


@pytest.mark.slow
def test_a_camera_that_is_stuck_in_a_slow_press(tiny_folders, tmp_path):
    """The force changes by newtons over many images, though by less than one from image to image."""
    log = copy_tree(tiny_folders[0], tmp_path / "log")
    first, *others = sorted((log / "frames").iterdir())
    for image in others:
        shutil.copy(first, image)
    assert said(log, tmp_path) == {("camera-stuck", "")}
