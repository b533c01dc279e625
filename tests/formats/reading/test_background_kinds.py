"""A picture without contact is held to the rules of recorded pictures: what is not 8-bit RGB is said, or not taken."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pytest
from copied_trees import copy_tree
from generators.collect import read
from generators.folder_log import SENSOR, write

from tactiledata.errors import UsageError
from tactiledata.formats.folder.folder import FolderFormat
from tactiledata.formats.image_folder import ImageFolderFormat
from tactiledata.store.change.add_sensor import add_sensor
from tactiledata.store.read.reader import Store


def png(pixels):
    return cv2.imencode(".png", pixels)[1].tobytes()


def four_inks():
    """A JPEG of cyan, magenta, yellow and black, which decoders do read."""
    image = pytest.importorskip("PIL.Image")
    buffer = io.BytesIO()
    image.new("CMYK", (24, 32), (10, 90, 200, 30)).save(buffer, "JPEG")
    return buffer.getvalue()


LEVELS = np.random.default_rng(0).integers(0, 256, (32, 24, 3))
KINDS = {
    "8-bit RGB": (png(LEVELS.astype(np.uint8)), ""),
    "16-bit colour": (png((LEVELS * 257).astype(np.uint16)), "image-depth"),
    "8-bit grey": (png(LEVELS[..., 0].astype(np.uint8)), "greyscale-image"),
    "16-bit grey": (png((LEVELS[..., 0] * 257).astype(np.uint16)), "lost"),
    "16-bit dark": (png((LEVELS * 15).astype(np.uint16)), "lost"),
    "four inks": (None, "lost"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("place", ["log.yaml", "image folder"])
def test_a_background_of_another_kind_is_said_or_left_out(kind, place, tmp_path):
    """What reads by its upper 8 bits or as grey is a warning; what would lose its meaning is damage, and not taken."""
    payload, code = KINDS[kind]
    payload = payload or four_inks()
    if place == "log.yaml":
        write(tmp_path / "log")
        (tmp_path / "log" / "backgrounds" / f"{SENSOR}.png").write_bytes(payload)
        [(recording, _)] = read(FolderFormat(), tmp_path / "log", None)
        serial = SENSOR
    else:
        (tmp_path / "run").mkdir()
        cv2.imwrite(str(tmp_path / "run" / "1.png"), LEVELS.astype(np.uint8))
        (tmp_path / "run" / "background.png").write_bytes(payload)
        serial = "D7"
        mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "run", "sensor": serial}}}
        [(recording, _)] = read(ImageFolderFormat(), tmp_path / "run", mapping)
    said = {(one.code, one.severity) for one in recording.findings if "ackground" in one.message}
    if code == "lost":
        assert serial not in recording.references
        assert said == {("background-broken", "damage")}
        return
    assert said == ({(code, "warning")} if code else set())
    if kind != "8-bit grey":
        np.testing.assert_array_equal(recording.references[serial], LEVELS[..., ::-1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_background_added_by_hand_of_another_kind(kind, tiny_store, tmp_path):
    """`sensors add` says the same of a picture, and refuses one that would lose its meaning; the store stays."""
    payload, code = KINDS[kind]
    payload = payload or four_inks()
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    (tmp_path / "picture.png").write_bytes(payload)
    if code == "lost":
        with pytest.raises(UsageError, match=r"picture\.png .* cannot|picture\.png .* is not a picture"):
            add_sensor(store, "D9", tmp_path / "picture.png", unchecked=True)
        assert "D9" not in Store.open(store).sensors()
        return
    found = add_sensor(store, "D9", tmp_path / "picture.png", unchecked=True)
    assert {one.code for one in found} - {"background-one-frame", "image-size"} == ({code} if code else set())
