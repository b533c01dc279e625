"""Images of one colour among good ones are found, marked and left out; dark pictures of gels are not."""

import cv2
import numpy as np
import pytest

from tactiledata.contract.take import FrameFlag, findings_of
from tactiledata.ingest.checks.blank_images import is_one_colour
from tactiledata.ingest.pipeline import ingest
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tactiledata.store.read.reader import Store

GEL = load_background("digit-bg-0")[::4, ::4]


def recorded(folder, pictures, suffix):
    """A store of a folder of pictures (H, W, 3) RGB."""
    run = folder / "run"
    run.mkdir()
    for number, picture in enumerate(pictures):
        cv2.imwrite(str(run / f"{number:02d}{suffix}"), picture[..., ::-1])
    ingest([run], folder / "ds.zarr")
    return Store.open(folder / "ds.zarr")


def gel(number, gain=1.0):
    noise = np.random.default_rng(number).normal(0, 1.5, GEL.shape)
    return np.clip(gain * GEL + noise, 0, 255).astype(np.uint8)


def flat(level, noise=0.0):
    made = level + np.random.default_rng(9).normal(0, noise, GEL.shape)
    return np.clip(np.rint(made), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
@pytest.mark.parametrize("blank", [flat(0), flat(255), flat(0, 0.8), flat(np.array([90, 20, 140]))])
@pytest.mark.parametrize("places", [(7,), (0,), (19,), (3, 4, 11)])
def test_an_image_of_one_colour_is_marked(tmp_path, suffix, blank, places):
    """Black, white, noisy black or one hue, at any place: named, flagged, and not among what is learned from."""
    pictures = [blank if number in places else gel(number) for number in range(20)]
    store = recorded(tmp_path, pictures, suffix)
    flags = store.frames(["flags"])["flags"].to_numpy()
    assert np.flatnonzero(flags & FrameFlag.BLANK).tolist() == list(places)
    (said,) = [one for one in findings_of(store.findings()) if one.code == "image-blank"]
    assert (said.severity, said.count) == ("warning", len(places))
    assert f"of 20 of camera 'tactile', of one colour throughout: number {places[0]}" in said.message
    arrays = TactileArrays(tmp_path / "ds.zarr", "all", ("tactile",), allow_leaks=True)
    assert len(arrays) == 20 - len(places)
    assert arrays.report.left_out == {"an image of one colour": len(places)}


def test_a_camera_that_is_dark_from_some_moment_on_is_seen(tmp_path):
    """Most images black: all of them are marked, although the usual size of a file is theirs."""
    store = recorded(tmp_path, [gel(number) if number < 5 else flat(0, 1.0) for number in range(20)], ".png")
    flags = store.frames(["flags"])["flags"].to_numpy()
    assert np.flatnonzero(flags & FrameFlag.BLANK).tolist() == list(range(5, 20))


@pytest.mark.parametrize("gain", [0.25, 1.0])
def test_pictures_of_a_gel_are_not_blank(tmp_path, gain):
    """Negative control: gels, in poor light too, and one image that is smaller because it is smooth."""
    pictures = [gel(number, gain) for number in range(20)]
    pictures[6] = cv2.GaussianBlur(pictures[6], (0, 0), 3.0)
    store = recorded(tmp_path, pictures, ".png")
    assert not (store.frames(["flags"])["flags"].to_numpy() & FrameFlag.BLANK).any()


def test_every_bundled_gel_has_more_than_one_colour():
    """The limit is far from pictures of gels: none of the 18 is of one colour at a third of its brightness."""
    assert not any(is_one_colour((load_background(name) // 3).astype(np.uint8)) for name in bundled_backgrounds())
    assert is_one_colour(flat(40, 2.5))
    assert not is_one_colour(flat(40, 3.5))
