"""Whether two pictures without contact are of one sensor."""

from itertools import combinations

import cv2
import numpy as np
import pytest

from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tactiledata.sensors.same_sensor import is_same_sensor, levels_apart

PICTURE = load_background("digit-bg-5")


def test_levels_apart_by_hand():
    """Half of the pixels by 3 grey levels and half by 1 is 2 grey levels, whichever picture is brighter."""
    first = np.full((4, 2, 3), 100, np.uint8)
    second = first.copy()
    second[:2] += 3
    second[2:] -= 1
    assert levels_apart(first, second) == levels_apart(second, first) == 2.0


def test_no_two_bundled_sensors_are_one():
    """Negative control: each of the 18 pictures is its own sensor, at full size and as small as checkpoints keep it."""
    pictures = [load_background(name) for name in bundled_backgrounds()]
    small = [cv2.resize(picture, (30, 40), interpolation=cv2.INTER_AREA) for picture in pictures]
    assert not any(is_same_sensor(first, second) for first, second in combinations(pictures, 2))
    assert not any(is_same_sensor(first, second) for first, second in combinations(small, 2))


@pytest.mark.parametrize("change", ["noise", "jpeg", "exposure", "size"])
def test_a_near_copy_is_the_same_sensor(change):
    """Noise, a lossy file, a few grey levels of exposure and another size hide no sensor."""
    rng = np.random.default_rng(0)
    copies = {
        "noise": np.clip(PICTURE + rng.normal(0, 5, PICTURE.shape), 0, 255).astype(np.uint8),
        "jpeg": cv2.imdecode(cv2.imencode(".jpg", PICTURE, [cv2.IMWRITE_JPEG_QUALITY, 40])[1], cv2.IMREAD_COLOR),
        "exposure": np.clip(PICTURE * 1.04, 0, 255).astype(np.uint8),
        "size": cv2.resize(PICTURE, (120, 160), interpolation=cv2.INTER_AREA),
    }
    assert is_same_sensor(PICTURE, copies[change])
