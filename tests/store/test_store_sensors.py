"""Pictures without contact that are added by hand: in the place of others, taken out again, kept through all else."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from copied_trees import copy_tree

from tactiledata.errors import MissingFile, StoreError, UsageError
from tactiledata.ingest.pipeline import ingest
from tactiledata.sensors.backgrounds import load_background
from tactiledata.store.change.add_sensor import add_sensor, remove_sensor
from tactiledata.store.check.check import check
from tactiledata.store.read.free_air import free_air_median
from tactiledata.store.read.reader import Store
from tactiledata.store.write.recover import begin_commit


@pytest.fixture
def store(tiny_store: Path, tmp_path: Path) -> Path:
    """A copy of the tiny store, whose backgrounds came with its recordings."""
    return copy_tree(tiny_store, tmp_path / "ds.zarr")


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    """A grey picture of a DIGIT's size."""
    cv2.imwrite(str(tmp_path / "grey.png"), np.full((320, 240, 3), 77, np.uint8))
    return tmp_path / "grey.png"


def test_a_picture_of_a_recording_is_replaced_only_when_asked(store: Path, picture: Path) -> None:
    """Without ``replace`` it is refused, the way out named; with it the store has the new picture, and is whole."""
    serial = next(iter(Store.open(store).references()))
    with pytest.raises(UsageError, match="--replace"):
        add_sensor(store, serial, picture)
    before = Store.open(store)
    assert before.reference(serial).image.mean() != 77
    add_sensor(store, serial, picture, replace=True, unchecked=True)
    after = Store.open(store)
    assert (after.reference(serial).image == 77).all()
    assert after.digest != before.digest
    assert check(store, images=False) == []


def test_what_is_no_file_is_not_said_to_be_missing(store: Path, tmp_path: Path) -> None:
    """A folder, a pipe and a device are called so; only a name without anything is said not to exist."""
    os.mkfifo(tmp_path / "pipe")
    for path, words in ((tmp_path, "is a folder"), (tmp_path / "pipe", "is a pipe"), (Path("/dev/zero"), "a device")):
        with pytest.raises(UsageError, match=f"{words}.*expected a JPEG or PNG file"):
            add_sensor(store, "D9", path)
    with pytest.raises(MissingFile, match="does not exist"):
        add_sensor(store, "D9", tmp_path / "gone.png")


@pytest.mark.slow
def test_a_picture_by_hand_outlasts_a_replaced_recording(store: Path, picture: Path, tiny_mcaps: list[Path]) -> None:
    """What was added by hand stays when the recordings of the sensor are read again."""
    serial = next(iter(Store.open(store).references()))
    add_sensor(store, serial, picture, replace=True, unchecked=True)
    ingest(tiny_mcaps, store, replace=True)
    assert (Store.open(store).reference(serial).image == 77).all()


@pytest.mark.slow
def test_what_was_added_wrongly_is_removed(store: Path, picture: Path, tiny_mcaps: list[Path]) -> None:
    """A sensor that only a hand named goes wholly; of one that recordings name, the picture goes, and can come back."""
    before = Store.open(store)
    add_sensor(store, "D9", picture)
    assert "D9" in Store.open(store).sensors()
    remove_sensor(store, "D9")
    after = Store.open(store)
    assert (after.sensors(), list(after.references())) == (before.sensors(), list(before.references()))
    serial, recorded = next(iter(before.references().items()))
    add_sensor(store, serial, picture, replace=True, unchecked=True)
    remove_sensor(store, serial)
    assert serial in Store.open(store).sensors()
    assert serial not in Store.open(store).references()
    assert check(store, images=False) == []
    ingest(tiny_mcaps, store, replace=True)
    assert (Store.open(store).reference(serial).image == recorded.image).all()


def test_pictures_of_recordings_are_not_removed(store: Path) -> None:
    """Only what a hand added can be taken out by hand; the message says what to do with the others."""
    for name in (next(iter(Store.open(store).references())), "D9"):
        with pytest.raises(UsageError, match="ingest RECORDING --replace"):
            remove_sensor(store, name)


def test_a_touch_is_told_by_the_stores_own_frames(store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A frame of largest force is refused as a background; one in free air is taken."""
    monkeypatch.setattr("tactiledata.store.read.free_air.LEAST_FRAMES", 1)  # the tiny world has few
    opened = Store.open(store)
    serial = next(name for name in opened.references() if free_air_median(opened, name) is not None)
    frames = opened.frames(["sensor", "contact_force"]).to_pandas()
    own = frames[frames["sensor"] == serial]
    for row, name in ((own["contact_force"].idxmax(), "touched"), (own["contact_force"].idxmin(), "free")):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.asarray(opened.images([int(row)])[0])[..., ::-1])
    with pytest.raises(UsageError, match=r"touched\.png differs by .* in free air"):
        add_sensor(store, serial, tmp_path / "touched.png", replace=True)
    add_sensor(store, serial, tmp_path / "free.png", replace=True)
    assert "free.png" in Store.open(store).reference(serial).origin


def test_facts_that_were_changed_are_not_believed(store: Path) -> None:
    """One character of a sensor's facts is another: reading them names the sensor; all other reading goes on."""
    place = store / "sensors.json"
    place.write_text(place.read_text().replace("digit", "dihit", 1))
    opened = Store.open(store)
    with pytest.raises(
        StoreError, match=r"the facts of sensor \S+ in .*sensors\.json are not those that were written.*from a copy"
    ):
        opened.sensors()
    assert opened.trajectories().num_rows > 0
    assert "store-sensors" in {finding.code for finding in check(store, images=False)}


def test_facts_of_a_commit_that_was_killed_are_read(store: Path) -> None:
    """A commit that ended between the sensors' file and the manifest left newer facts: they are no damage."""
    place = store / "sensors.json"
    before = Store.open(store).sensors()
    begin_commit(store, Store.open(store).manifest)
    place.write_text(place.read_text().replace("digit", "other", 1))
    assert Store.open(store).sensors() == before


@pytest.mark.parametrize("name", ["a\nb", "a\x1b[2Jb", "\0", "a/b", "a\\b", "..", ".", " ", "", "n" * 201])
def test_what_is_no_name_of_a_sensor_is_refused(store: Path, picture: Path, name: str) -> None:
    """The names that log.yaml may not have, a picture may not have either: the store keeps its sensors."""
    before = Store.open(store).digest
    with pytest.raises(UsageError, match="sensor name"):
        add_sensor(store, name, picture)
    assert Store.open(store).digest == before
    add_sensor(store, "Fühler-1 (links)", picture)


def test_a_picture_of_one_colour_is_said(store: Path, picture: Path, tmp_path: Path) -> None:
    """A grey or black picture is kept and said, whatever its size; one of a gel is not."""
    cv2.imwrite(str(tmp_path / "black.png"), np.zeros((20, 20, 3), np.uint8))
    gel = load_background("digit-bg-3")
    cv2.imwrite(str(tmp_path / "gel.png"), gel[..., ::-1])
    said = {
        file: {finding.code: finding.severity for finding in add_sensor(store, f"of {file}", tmp_path / file)}
        for file in ("grey.png", "black.png", "gel.png")
    }
    assert said["grey.png"]["background-blank"] == said["black.png"]["background-blank"] == "warning"
    assert "background-blank" not in said["gel.png"]
