"""Transfers by pixels: each keeps its closed form, on real backgrounds and a real contact."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.pixels.fourier import low_frequencies
from split_models.transfer.pixels.reinhard import statistics
from tactiledata.errors import UnknownName, UsageError
from tactiledata.sensors.backgrounds import load_background

CONTACT = Path(__file__).parents[2] / "data" / "digit_contact" / "digit_raw.png"
ALL = sorted(PIXEL_TRANSFERS)
FROM_BACKGROUNDS = ["background_swap", "background_ratio", "histogram_matching", "reinhard"]
"""Methods that look at the picture only through the two backgrounds."""


@pytest.fixture(scope="module")
def source():
    return load_background("digit-bg-3")


@pytest.fixture(scope="module")
def target():
    return load_background("ycb-sensorB")


@pytest.fixture(scope="module")
def touched():
    """A real contact, and it at half its contrast: (2, 320, 240, 3)."""
    contact = cv2.imread(str(CONTACT), cv2.IMREAD_COLOR_RGB)
    return np.stack([contact, contact // 2])


@pytest.mark.parametrize("name", FROM_BACKGROUNDS)
def test_same_background_changes_nothing(name, touched, source):
    """From a sensor to itself a touch stays as it is, to the rounding of a level."""
    moved = PIXEL_TRANSFERS[name].transfer(touched, source, source)
    assert np.abs(moved.astype(int) - touched).max() <= 1


@pytest.mark.parametrize("name", ["no_contact", "background_swap", "background_ratio"])
def test_background_maps_to_background(name, source, target):
    """The source without contact becomes the target without contact, exactly."""
    np.testing.assert_array_equal(PIXEL_TRANSFERS[name].transfer(source[None], source, target)[0], target)


def test_a_ratio_of_light_is_moved_exactly(source, target):
    """What a touch does to the light by a factor it does on the target, where neither picture is dark or clips.

    A swap, the negative control, is wrong by more than a level there.
    """
    factor = np.linspace(0.7, 1.1, source.shape[0])[:, None, None]
    both = np.minimum(source, target)
    inside = (both >= 8) & (np.maximum(source, target) * 1.1 < 255)
    touched, truth = (np.clip(np.rint(one * factor), 0, 255).astype(np.uint8) for one in (source, target))
    off = {
        name: np.abs(PIXEL_TRANSFERS[name].transfer(touched[None], source, target)[0].astype(int) - truth)[inside]
        for name in ("background_ratio", "background_swap")
    }
    coarse = 1 + 0.5 * (target / np.maximum(source, 1.0))[inside]  # a rounded level of the source is so many here
    assert inside.mean() > 0.5
    assert (off["background_ratio"] <= coarse).all()
    assert off["background_swap"].mean() > 2


def test_histogram_of_the_background_maps_to_the_targets(source, target):
    """Sorted grey levels of the mapped background are the target's, to the coarseness of grey levels."""
    moved = PIXEL_TRANSFERS["histogram_matching"].transfer(source[None], source, target)[0]
    for channel in range(3):
        ours, theirs = (np.sort(picture[..., channel].ravel()).astype(int) for picture in (moved, target))
        assert np.abs(ours - theirs).mean() < 2
        assert np.abs(np.sort(source[..., channel].ravel()).astype(int) - theirs).mean() > 4


def test_histogram_matching_is_scikit_images_on_the_background(source, target):
    """On the source background itself the map is the library's, to a level."""
    exposure = pytest.importorskip("skimage.exposure")
    moved = PIXEL_TRANSFERS["histogram_matching"].transfer(source[None], source, target)[0]
    theirs = exposure.match_histograms(source, target, channel_axis=2)
    assert np.abs(moved.astype(float) - theirs).max() <= 1


def test_histogram_matching_keeps_order_and_contrast_beyond_the_background(target):
    """Levels that the background lacks stay in order, and keep their distance from its nearest end."""
    flat = np.full_like(target, 100)
    grey = np.arange(256, dtype=np.uint8).repeat(3).reshape(1, 16, 16, 3)
    goal = np.full((16, 16, 3), 120, np.uint8)
    moved = PIXEL_TRANSFERS["histogram_matching"].transfer(grey, flat[:16, :16], goal)
    np.testing.assert_array_equal(moved, np.clip(grey.astype(int) + 20, 0, 255))


def test_reinhard_gives_the_targets_statistics(source, target):
    """Mean and spread in CIELAB of the mapped background are the target's, within what 8 bits and clipping leave."""
    moved = PIXEL_TRANSFERS["reinhard"].transfer(source[None], source, target)[0]
    ours, goal, before = (np.stack(statistics(picture.astype(np.float32))) for picture in (moved, target, source))
    assert np.abs(ours - goal).max() < 0.5
    assert np.abs(before - goal).max() > 5


def test_fourier_takes_low_amplitudes_only(touched, source, target):
    """Amplitude of the low frequencies is the target's, all else the picture's, phases too."""
    moved = PIXEL_TRANSFERS["fourier"].change(
        touched.astype(np.float32), source.astype(np.float32), target.astype(np.float32)
    )
    rows, columns = low_frequencies(touched.shape[1:3])
    ours, before, goal = (np.fft.rfft2(one, axes=(-3, -2)) for one in (moved, touched, target))
    window = np.ix_(rows, columns)
    np.testing.assert_allclose(np.abs(ours[0][window]), np.abs(goal[window]), rtol=1e-3, atol=1)
    np.testing.assert_allclose(np.exp(1j * np.angle(ours[0][window])), np.exp(1j * np.angle(before[0][window])), 1e-2)
    outside = np.ones(before.shape[1:3], bool)
    outside[window] = False
    np.testing.assert_allclose(ours[0][outside], before[0][outside], rtol=1e-3, atol=5)


def test_fourier_leaves_the_target_itself(source, target):
    """A picture whose amplitudes are the target's already is not changed."""
    np.testing.assert_array_equal(PIXEL_TRANSFERS["fourier"].transfer(target[None], source, target)[0], target)


def test_there_and_back_is_the_touch(source, target, touched):
    """Swapped to the target and back, a touch that nowhere clips is itself; clipped pixels are the only loss."""
    swap = PIXEL_TRANSFERS["background_swap"]
    there = swap.transfer(touched, source, target)
    back = swap.transfer(there, target, source)
    whole = touched.astype(int) - source + target
    inside = (whole >= 0) & (whole <= 255)
    assert inside.mean() > 0.5
    np.testing.assert_array_equal(back[inside], touched[inside])


@pytest.mark.parametrize("name", ALL)
def test_batch_is_picture_by_picture(name, touched, source, target):
    """A batch gives what its pictures give alone, uint8, of the same shape; an empty batch an empty one."""
    method = PIXEL_TRANSFERS[name]
    together = method.transfer(touched, source, target)
    alone = np.concatenate([method.transfer(one[None], source, target) for one in touched])
    assert together.dtype == np.uint8
    np.testing.assert_array_equal(together, alone)
    assert method.transfer(touched[:0], source, target).shape == (0, 320, 240, 3)
    assert method.name == name


@pytest.mark.parametrize("name", ["background_swap", "fourier"])
@pytest.mark.parametrize(
    ("images", "source_shape", "target_shape", "says"),
    [
        ((1, 20, 12, 3), (20, 12, 3), (12, 20, 3), "target background"),
        ((1, 20, 12, 3), (40, 24, 3), (20, 12, 3), "source background"),
        ((20, 12, 3), (20, 12, 3), (20, 12, 3), r"\(n, H, W, 3\)"),
        ((1, 20, 12, 4), (20, 12, 4), (20, 12, 4), r"\(n, H, W, 3\)"),
    ],
)
def test_other_shapes_are_refused(name, images, source_shape, target_shape, says):
    """A size that differs is an error that says whose, never a resampling."""
    blank = [np.zeros(shape, np.uint8) for shape in (images, source_shape, target_shape)]
    with pytest.raises(UsageError, match=says):
        PIXEL_TRANSFERS[name].transfer(*blank)


def test_floats_are_refused(target):
    """Pictures in [0, 1] would come out black: they are refused."""
    with pytest.raises(UsageError, match="uint8"):
        PIXEL_TRANSFERS["background_swap"].transfer(target[None] / 255, target, target)


def test_unknown_method_lists_near_names():
    """A misspelt method is told the near ones."""
    with pytest.raises(UnknownName, match="Did you mean background_swap"):
        PIXEL_TRANSFERS["background_swop"]
