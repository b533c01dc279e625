"""Plain folders of images: natural order, masks left, no clock made up."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from generators import folder_log
from generators.collect import codes, read
from generators.folder_log import picture

from tactiledata.contract.own_files import marked_png
from tactiledata.errors import BrokenLog, SchemaError, UnsafeContent, UsageError
from tactiledata.formats.image_folder import ImageFolderFormat

DATA = Path(__file__).resolve().parents[1] / "data"
FORMAT = ImageFolderFormat()
MAPPING = {
    "format": "tactiledata-mapping/1",
    "images": {"digit": {"topic": "run", "sensor": "D20542"}},
}


def read_one(path, mapping=None):
    [(recording, sink)] = read(FORMAT, path, mapping)
    return recording, sink.images


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    rng = np.random.default_rng(3)
    for name in ("10.png", "9.png", "1.jpg"):
        picture(folder / name, rng, (32, 24))
    return folder


def test_real_digit_contacts_go_in():
    """The real DIGIT contacts are two frames as they came; the drawn mask and the licence are named and left."""
    recording, images = read_one(DATA / "digit_contact")
    assert [image.name for image in images] == ["digit_raw.png", "limitation_raw_digit.png"]
    for image in images:
        assert image.payload == (DATA / "digit_contact" / image.name).read_bytes()
        assert (image.encoding, image.height, image.width) == ("png", 320, 240)
    assert codes(recording) == {"no-clock", "mask-left", "not-an-image"}
    [mask] = [finding for finding in recording.findings if finding.code == "mask-left"]
    assert "digit_mask.png' is a mask" in mask.message


def test_pictures_that_commands_drew_are_no_frames(run, tmp_path):
    """The picture of a page is left, and named; a folder of such pictures alone is no recording."""
    page = tmp_path / "page"
    page.mkdir()
    drawn = page / "recorded.png"
    picture(drawn, np.random.default_rng(0), (32, 24))
    assert FORMAT.sniff(page)
    drawn.write_bytes(marked_png(drawn.read_bytes()))
    assert not FORMAT.sniff(page)
    shutil.copy(drawn, run / "recorded.png")
    recording, images = read_one(run)
    assert [image.name for image in images] == ["1.jpg", "9.png", "10.png"]
    (left,) = [finding for finding in recording.findings if finding.code == "picture-drawn"]
    assert "'recorded.png' was drawn by a command of tactiledata" in left.message


def test_natural_order_is_the_only_clock(run):
    """Files come as people count, stamped with their index, in one trajectory named after the folder."""
    recording, images = read_one(run)
    assert [(image.name, image.log_ns) for image in images] == [("1.jpg", 0), ("9.png", 1), ("10.png", 2)]
    [whole] = recording.trajectories
    assert (whole.name, whole.start_ns, whole.end_ns) == ("run", 0, 3)
    assert {image.trajectory for image in images} == {"run"}
    assert codes(recording) == {"no-clock"}


def test_mapping_names_sensor_and_stream(run):
    """A mapping gives the sensor, and its background file becomes the sensor's reference."""
    truth = picture(run / "BG.png", np.random.default_rng(1), (32, 24))
    recording, images = read_one(run, MAPPING)
    assert {(image.camera, image.sensor) for image in images} == {("digit", "D20542")}
    assert len(images) == 3
    expected = cv2.imdecode(np.frombuffer(truth, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    np.testing.assert_array_equal(recording.references["D20542"], expected)
    assert recording.reference_sources["D20542"] == "BG.png"
    assert recording.description.sensors == {"D20542": {"model": "digit"}}
    assert codes(recording) == {"no-clock"}


def test_background_named_by_a_mapping_wins(run):
    """A background that the description names is the reference, and no frame."""
    mapping = {**MAPPING, "description": {"sensors": {"D20542": {"model": "digit", "background": "9.png"}}}}
    recording, images = read_one(run, mapping)
    assert [image.name for image in images] == ["1.jpg", "10.png"]
    assert recording.reference_sources == {"D20542": "9.png"}


def test_background_without_sensor_is_reported(run):
    """Whose background it is cannot be guessed."""
    picture(run / "background.jpg", np.random.default_rng(1), (32, 24))
    recording, images = read_one(run)
    assert len(images) == 3
    assert recording.references == {}
    assert "background-without-sensor" in codes(recording)


def test_mapping_cuts_the_folder_into_trajectories(run):
    """Intervals of indices in a description make several trajectories, with their sensors."""
    touches = [
        {"trajectory": "a", "start_ns": 0, "end_ns": 1, "sensor": "D1", "indenter": "ball4"},
        {"trajectory": "b", "start_ns": 1, "end_ns": 2, "depth": 0.5},
    ]
    sensors = {name: {"model": "digit"} for name in ("D1", "D20542")}
    recording, images = read_one(run, {**MAPPING, "description": {"sensors": sensors, "trajectories": touches}})
    assert [(image.trajectory, image.sensor) for image in images] == [("a", "D1"), ("b", "D20542"), ("", "D20542")]
    assert recording.trajectories[1].extra == {"depth": 0.5}


def test_colour_picture_named_mask_is_a_frame(run):
    """Only 8-bit grey makes a mask; a grey frame is taken with a warning."""
    picture(run / "a_mask.png", np.random.default_rng(1), (32, 24))
    cv2.imwrite(str(run / "b_mask.png"), np.zeros((32, 24), np.uint8))
    cv2.imwrite(str(run / "c.png"), np.zeros((32, 24), np.uint8))
    recording, images = read_one(run)
    assert {image.name for image in images} == {"1.jpg", "9.png", "10.png", "a_mask.png", "c.png"}
    assert {"mask-left", "greyscale-image"} <= codes(recording)


DEEP = np.full((32, 24, 3), 40_000, np.uint16)
FAULTS = {
    "cut": (lambda run: (run / "9.png").write_bytes((run / "9.png").read_bytes()[:900]), "image-truncated", "damage"),
    "empty": (lambda run: (run / "9.png").write_bytes(b""), "image-unreadable", "damage"),
    "text": (lambda run: (run / "9.png").write_bytes(b"<html>"), "image-unreadable", "damage"),
    "deep": (
        lambda run: cv2.imwrite(str(run / "9.png"), DEEP),
        "image-depth",
        "warning",
    ),
    "link": (lambda run: (run / "11.png").symlink_to("/etc/passwd"), "link-left", "warning"),
    "stranger": (lambda run: (run / "movie.mp4").write_bytes(b"x"), "not-an-image", "info"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_named_and_keeps_its_moment(run, fault):
    """A bad file is named; every image file still has its moment."""
    plant, code, severity = FAULTS[fault]
    plant(run)
    recording, images = read_one(run)
    assert [finding.severity for finding in recording.findings if finding.code == code] == [severity]
    assert [image.log_ns for image in images] == [0, 1, 2]


def test_broken_background(run):
    """A background that does not decode is damage."""
    (run / "bg.png").write_bytes(b"\x89PNG")
    recording, _ = read_one(run, MAPPING)
    assert "background-broken" in codes(recording)


def test_mapping_faults(run):
    """Two cameras for one folder, a path that leads out and a broken description are refused."""
    with pytest.raises(UsageError, match="2 cameras"):
        read_one(run, {"images": {"left": {"topic": "x"}, "right": {"topic": "y"}}})
    outside = {"sensors": {"D20542": {"model": "digit", "background": "../bg.png"}}}
    with pytest.raises(UnsafeContent, match="leaves the folder"):
        read_one(run, {**MAPPING, "description": outside})
    with pytest.raises(SchemaError, match=r"\$\.sensors"):
        read_one(run, {**MAPPING, "description": {"sensors": {"D1": {"modell": "digit"}}}})


def test_folder_of_masks_alone(tmp_path):
    """A folder in which no picture is a frame is refused with what was expected."""
    cv2.imwrite(str(tmp_path / "a_mask.png"), np.zeros((8, 8), np.uint8))
    with pytest.raises(BrokenLog, match="no mask and no background"):
        read_one(tmp_path)


def test_sniff_leaves_other_recordings_alone(tmp_path, run):
    """A folder log, a rosbag folder with pictures, folders of folders and files are not claimed; a plain one is."""
    folder_log.write(tmp_path / "log", touches=1, frames=1)
    picture(tmp_path / "log" / "photo.png", np.random.default_rng(0), (8, 8))
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    picture(tmp_path / "bag" / "photo.png", np.random.default_rng(0), (8, 8))
    for path in (tmp_path, tmp_path / "log", tmp_path / "bag", run / "9.png", DATA / "gelsight_r15", DATA / "mcap"):
        assert not FORMAT.sniff(path), path
    assert FORMAT.sniff(run)
    (tmp_path / "log" / "log.yaml").unlink()
    assert not FORMAT.sniff(tmp_path / "log" / "frames")
    assert not FORMAT.sniff(tmp_path / "log" / "backgrounds")
    with pytest.raises(UsageError, match="not of format"):
        FORMAT.sources(tmp_path)
