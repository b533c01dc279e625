"""Backgrounds from several frames: untouched ones are averaged, a touch among them is found."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.sensors.average_background import average_background, refuse_swapped_channels
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background

CONTACTS = Path(__file__).parents[1] / "data" / "digit_contact"
UNITS = list(bundled_backgrounds())


def contact(name):
    return cv2.imread(str(CONTACTS / f"{name}.png"), cv2.IMREAD_COLOR_RGB)


def noisy(image, count, seed=0, noise=2.0):
    rng = np.random.default_rng(seed)
    return [np.clip(image + rng.normal(0, noise, image.shape), 0, 255).astype(np.uint8) for _ in range(count)]


def touched(image, strength=0.5):
    """A unit's picture with the change that a real contact makes, filled in from its surroundings, laid on it."""
    mask = cv2.imread(str(CONTACTS / "digit_mask.png"), cv2.IMREAD_GRAYSCALE)
    mask = (cv2.resize(mask, (240, 320), interpolation=cv2.INTER_NEAREST) > 0).astype(np.uint8)
    raw = contact("digit_raw")
    filled = cv2.inpaint(raw, cv2.dilate(mask, np.ones((25, 25), np.uint8)), 15, cv2.INPAINT_TELEA)
    return np.clip(image + strength * (raw.astype(float) - filled), 0, 255).astype(np.uint8)


def test_mean_has_less_noise():
    """Sixteen frames leave a quarter of one frame's noise, and rounding."""
    true = np.clip(load_background("digit-bg-2"), 20, 235)
    mean = average_background(noisy(true, 16, noise=4.0), [str(number) for number in range(16)])
    assert 0.8 < (mean - true.astype(float)).std() < 1.3


@pytest.mark.parametrize("unit", UNITS)
def test_untouched_frames_are_no_touch(unit):
    """Negative control: noisy frames of every real unit are averaged without a word."""
    frames = noisy(load_background(unit), 3)
    assert average_background(frames, list("abc")).shape == (320, 240, 3)


@pytest.mark.parametrize(
    "unit", [pytest.param(unit, marks=[pytest.mark.slow] * bool(i % 16)) for i, unit in enumerate(UNITS)]
)
def test_a_touch_among_frames_is_named(unit):
    """On every real unit, the one frame with a contact at half its strength is named, and no other."""
    frames = noisy(load_background(unit), 4)
    frames[2] = noisy(touched(load_background(unit)), 1, seed=5)[0]
    with pytest.raises(UsageError, match=r"c\.png shows a touch") as caught:
        average_background(frames, ["a.png", "b.png", "c.png", "d.png"])
    assert caught.value.facts["touched"] == ["c.png"]


def test_two_real_contacts_are_refused():
    """Two real contacts of one unit differ; which of two frames is untouched cannot be told, so both are named."""
    frames = [contact("digit_raw"), contact("limitation_raw_digit")]
    with pytest.raises(UsageError, match="digit_raw and limitation differ"):
        average_background(frames, ["digit_raw", "limitation"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["digit_raw", "limitation_raw_digit"])
def test_a_real_contact_among_untouched_frames_is_found(name):
    """A real contact between frames of its unit, whose untouched picture is filled in from the surroundings."""
    mask = cv2.resize(cv2.imread(str(CONTACTS / "digit_mask.png"), cv2.IMREAD_GRAYSCALE), (240, 320))
    wide = cv2.dilate((mask > 0).astype(np.uint8), np.ones((25, 25), np.uint8))
    untouched = cv2.inpaint(contact("digit_raw"), wide, 15, cv2.INPAINT_TELEA)
    with pytest.raises(UsageError, match=f"{name} shows a touch"):
        average_background([*noisy(untouched, 3), contact(name)], ["a", "b", "c", name])


def test_sizes_that_differ_are_refused():
    """Frames of two camera settings are not averaged."""
    with pytest.raises(UsageError, match=r"b\.png has 240 rows x 320 columns and a\.png has 320 rows"):
        average_background([np.zeros((320, 240, 3), np.uint8), np.zeros((240, 320, 3), np.uint8)], ["a.png", "b.png"])
    with pytest.raises(UsageError, match="one or more"):
        average_background([], [])


@pytest.mark.parametrize("unit", UNITS)
def test_channels_of_real_units(unit):
    """No real unit is refused; swapped, all but an unsure one are."""
    image = load_background(unit)
    refuse_swapped_channels(image, unit)
    refuse_swapped_channels(image, unit, image)
    with pytest.raises(UsageError, match="red and blue of u are swapped"):
        refuse_swapped_channels(np.ascontiguousarray(image[..., ::-1]), "u", image)
