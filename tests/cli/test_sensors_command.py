"""`sensors`: what is listed, and pictures that are added from several frames or refused."""

import json

import cv2
import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.sensors.backgrounds import load_background
from tactiledata.store.read.reader import Store


@pytest.fixture
def folder(tiny_store, tmp_path, monkeypatch):
    """A working folder with one store, and three noisy frames of an untouched unit."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    rng = np.random.default_rng(0)
    true = load_background("digit-bg-5")
    for name in "abc":
        frame = np.clip(true + rng.normal(0, 3, true.shape), 0, 255).astype(np.uint8)
        cv2.imwrite(str(tmp_path / f"{name}.png"), frame[..., ::-1])
    cv2.imwrite(str(tmp_path / "bgr.png"), true)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_list_says_licence_attribution_and_what_names_stand_for(folder, capsys):
    """The store's sensors, the bundled pictures with their licence, and the two names of target sensors."""
    code, out, _ = run_command(capsys, "sensors", "--json")
    listed = json.loads(out)
    assert code == 0
    assert {row["sensor"] for row in listed["store"]} == {"D20001", "D20002"}
    assert len(listed["bundled"]) == 18
    assert all(one["licence"] == "MIT" and one["attribution"] for one in listed["bundled"].values())
    assert listed["names"] == {"ycb-sensorA": "digit-bg-0", "ycb-sensorB": "digit-bg-1"}


def test_several_frames_become_one_picture(folder, capsys):
    """The mean of all frames named after --background is kept, with licence and source."""
    words = ("sensors", "add", "D9", "--background", "a.png", "b.png", "c.png", "--licence", "CC0", "--source", "here")
    assert run_command(capsys, *words)[0] == 0
    kept = Store.open("ds.zarr").reference("D9")
    frames = [cv2.imread(f"{name}.png", cv2.IMREAD_COLOR_RGB) for name in "abc"]
    np.testing.assert_array_equal(kept.image, np.rint(np.mean(frames, axis=0)))
    assert (kept.origin, kept.licence) == ("added by hand: mean of 3 frames (a.png …), from here", "CC0")


def test_one_frame_is_taken_with_a_note(folder, capsys):
    """One frame cannot tell a touch, and that is said; several frames say nothing."""
    code, out, _ = run_command(capsys, "sensors", "add", "D9", "--background", "a.png", "--json")
    assert code == 0
    assert [finding["code"] for finding in json.loads(out)["findings"]] == ["background-one-frame"]
    code, out, _ = run_command(capsys, "sensors", "add", "D8", "--background", "a.png", "b.png", "--json")
    assert (code, json.loads(out)["findings"]) == (0, [])


def test_swapped_channels_are_refused_unless_unchecked(folder, capsys):
    """A BGR picture is wrong usage, and taken when one insists."""
    code, _, err = run_command(capsys, "sensors", "add", "D9", "--background", "bgr.png")
    assert code == 2
    assert "red and blue of bgr.png are swapped" in err
    assert "D9" not in Store.open("ds.zarr").sensors()
    assert run_command(capsys, "sensors", "add", "D9", "--background", "bgr.png", "--unchecked")[0] == 0


def test_info_names_sensors_without_a_recording(folder, capsys):
    """A sensor that was added by hand is said to hold nothing; a store of recorded ones says nothing of the kind."""
    assert "without a trajectory" not in run_command(capsys, "info", "ds.zarr")[1]
    assert run_command(capsys, "sensors", "add", "D30001", "--background", "a.png")[0] == 0
    out = run_command(capsys, "info", "ds.zarr")[1]
    assert "without a trajectory or an image, so that no split holds it: D30001" in out
