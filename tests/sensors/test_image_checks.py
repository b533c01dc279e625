"""Detectors on pictures, each with its negative control on real pictures."""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.errors import UsageError
from tactiledata.sensors import SENSORS
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tactiledata.sensors.image_checks import (
    CONTACT_LEVELS,
    LAYOUT_CERTAIN,
    channel_order,
    mean_layout,
    orientation_of,
    shows_contact,
)

CONTACTS = Path(__file__).parents[1] / "data" / "digit_contact"
NAMES = list(bundled_backgrounds())


def contact_picture(name):
    return cv2.imread(str(CONTACTS / f"{name}.png"), cv2.IMREAD_COLOR_RGB)


@pytest.fixture(scope="module")
def backgrounds():
    return [load_background(name) for name in NAMES]


@pytest.fixture(scope="module")
def drawn_mask():
    """The mask that the contact's authors drew, (320, 240): theirs is 256 columns wide."""
    mask = cv2.imread(str(CONTACTS / "digit_mask.png"), cv2.IMREAD_GRAYSCALE)
    return cv2.resize(mask, (240, 320), interpolation=cv2.INTER_NEAREST) > 0


@pytest.fixture(scope="module")
def filled_in(drawn_mask):
    """A stand-in for the contact's background, which was not published: the masked part filled in from around it."""
    wide = cv2.dilate(drawn_mask.astype(np.uint8), np.ones((25, 25), np.uint8))
    return cv2.inpaint(contact_picture("digit_raw"), wide, 15, cv2.INPAINT_TELEA)


@given(rows=st.integers(1, 700), columns=st.integers(1, 700))
def test_orientation_is_exact(rows, columns):
    """Only the canonical size is ok, only its swap is swapped."""
    image = np.zeros((rows, columns, 3), np.uint8)
    expected = {(320, 240): "ok", (240, 320): "swapped"}.get((rows, columns), "other size")
    assert orientation_of(image, SENSORS["digit"]) == expected


@pytest.mark.parametrize(("shape", "says"), [((320, 240), "ok"), ((240, 320), "swapped"), ((640, 480), "other size")])
def test_orientation_of_common_sizes(shape, says):
    """The orientation of upright, turned and VGA pictures of a DIGIT is told."""
    assert orientation_of(np.zeros((*shape, 3), np.uint8), SENSORS["digit"]) == says


def test_orientation_needs_a_camera():
    """A force sensor takes no pictures."""
    with pytest.raises(UsageError, match="takes no pictures"):
        orientation_of(np.zeros((2, 2, 3), np.uint8), SENSORS["robotiq_ft300s"])


def test_channel_order_of_units_left_out(backgrounds):
    """Leaving each unit out of the mean in turn: none wrong, at most one unsure, RGB and swapped alike."""
    verdicts = {"right": 0, "wrong": 0, "unsure": 0}
    for index, image in enumerate(backgrounds):
        mean = mean_layout(backgrounds[:index] + backgrounds[index + 1 :])
        for picture, sign in ((image, 1), (image[..., ::-1], -1)):
            score = sign * float((mean_layout([picture]) * mean).sum())
            verdicts["unsure" if abs(score) < LAYOUT_CERTAIN else "right" if score > 0 else "wrong"] += 1
    assert verdicts == {"right": 34, "wrong": 0, "unsure": 2}


@pytest.mark.parametrize("name", ["digit_raw", "limitation_raw_digit"])
def test_channel_order_of_contacts_of_an_unknown_unit(name):
    """Two real contacts of a unit that is not among the bundled ones are named, both ways."""
    image = contact_picture(name)
    assert channel_order(image).verdict == "rgb"
    assert channel_order(np.ascontiguousarray(image[..., ::-1])).verdict == "bgr"


def test_channel_order_against_the_units_own_picture(backgrounds):
    """With the unit's own picture every unit is named, noise and JPEG notwithstanding."""
    rng = np.random.default_rng(1)
    for image in backgrounds:
        seen = as_recorded(image, rng, quality=60)
        assert channel_order(seen, image).verdict == "rgb"
        assert channel_order(seen[..., ::-1], image).verdict == "bgr"


@pytest.mark.parametrize("image", [np.full((320, 240, 3), 90, np.uint8), np.zeros((320, 240), np.uint8)])
def test_channel_order_of_grey_pictures_is_unsure(image):
    """A picture without colours has no order to find."""
    assert channel_order(image).verdict == "unsure"


def test_channel_order_of_noise_is_unsure():
    """Pure noise is not mistaken for a layout."""
    rng = np.random.default_rng(2)
    noise = [rng.integers(0, 255, (320, 240, 3)).astype(np.uint8) for _ in range(20)]
    assert {channel_order(image).verdict for image in noise} == {"unsure"}


def as_recorded(image, rng, quality=50, noise=7.0):
    """The picture as a camera gives it again: noise, then JPEG."""
    noisy = np.clip(image + rng.normal(0, noise, image.shape), 0, 255).astype(np.uint8)
    encoded = cv2.imencode(".jpg", noisy[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB)


def shifted(image, right, down):
    move = np.array([[1, 0, right], [0, 1, down]], np.float32)
    return cv2.warpAffine(image, move, image.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)


@pytest.mark.slow
def test_real_contact_is_seen_where_it_is(filled_in, drawn_mask):
    """The real contact stands out by far, and where its authors drew it."""
    contact = shows_contact(contact_picture("digit_raw"), filled_in)
    assert contact.is_contact
    assert contact.score > 5 * CONTACT_LEVELS
    assert (contact.mask & drawn_mask).sum() / (contact.mask | drawn_mask).sum() > 0.75


def test_two_contacts_of_one_unit_differ():
    """One contact against another as background is a change too."""
    assert shows_contact(contact_picture("limitation_raw_digit"), contact_picture("digit_raw")).is_contact


@pytest.mark.slow
def test_weak_contact_is_seen_on_every_unit(backgrounds, filled_in):
    """The real contact at a quarter of its strength is seen on all 18 bundled pictures, under noise and JPEG."""
    rng = np.random.default_rng(3)
    change = contact_picture("digit_raw").astype(float) - filled_in
    for image in backgrounds:
        touched = np.clip(image + 0.25 * change, 0, 255).astype(np.uint8)
        assert shows_contact(as_recorded(touched, rng), image).is_contact


@pytest.mark.slow
def test_untouched_pictures_show_no_contact(backgrounds):
    """Noise, JPEG, a shift by a pixel and a changed brightness are no contact."""
    rng = np.random.default_rng(4)
    for image in backgrounds:
        controls = [
            image,
            as_recorded(image, rng),
            shifted(image, 1, 0),
            shifted(image, 0, 1),
            *(np.clip(image * gain, 0, 255).astype(np.uint8) for gain in (0.9, 0.95, 1.05)),
        ]
        assert [shows_contact(control, image).is_contact for control in controls] == [False] * len(controls)


def test_another_unit_is_no_background(backgrounds):
    """Against another unit's picture everything looks touched: the background must be the unit's own."""
    assert np.mean([shows_contact(image, other).is_contact for image, other in pairwise(backgrounds)]) > 0.9


def test_pictures_of_two_sizes_are_refused():
    """A background of another size is an error, not a resampling."""
    with pytest.raises(UsageError, match=r"\(320, 240, 3\)"):
        shows_contact(np.zeros((320, 240, 3), np.uint8), np.zeros((240, 320, 3), np.uint8))
