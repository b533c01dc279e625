"""Pictures decoded smaller are those of the areas they cover, whatever they are kept as."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.errors import UsageError
from tactiledata.store.read.scaled_pictures import average_into, decode_smaller_jpeg, need_smaller

BACKGROUNDS = sorted((Path(__file__).parents[3] / "tactiledata" / "sensors" / "digit_backgrounds").glob("*.jpg"))
FULL = (320, 240, 3)


@pytest.mark.parametrize("size", [(160, 120), (80, 60), (40, 30), (200, 150), (224, 224), (100, 31), (9, 8)])
def test_smaller_jpegs_are_means_over_areas(size):
    """Of real DIGIT pictures, at sizes that the transform has and at others: within half a grey level on average."""
    for path in BACKGROUNDS[::6]:
        content = path.read_bytes()
        smaller, expected = (np.zeros((*size, 3), np.uint8) for _ in range(2))
        assert decode_smaller_jpeg(content, FULL, smaller)
        average_into(decode_rgb(content), expected)
        difference = smaller.astype(int) - expected
        assert abs(difference).mean() < 0.6
        assert abs(difference).max() <= 8
        assert abs(difference.mean()) < 0.6
        shifted = np.roll(expected, max(1, size[0] // 20), axis=0)  # the bounds can be missed
        assert abs(smaller.astype(int) - shifted).max() > 8


def test_areas_are_averaged():
    """Halved, each pixel is the mean of four; at its own size a picture is copied."""
    picture = np.random.default_rng(0).integers(0, 256, (8, 6, 3)).astype(np.uint8)
    half, same = np.zeros((4, 3, 3), np.uint8), np.zeros_like(picture)
    average_into(picture, half)
    means = picture.reshape(4, 2, 3, 2, 3).mean(axis=(1, 3))
    assert abs(half - means).max() <= 0.5
    average_into(picture, same)
    np.testing.assert_array_equal(same, picture)


def test_what_is_no_such_jpeg_is_handed_on():
    """Another size than was recorded, a cut file and a PNG file are not taken."""
    content = BACKGROUNDS[0].read_bytes()
    target = np.zeros((160, 120, 3), np.uint8)
    assert not decode_smaller_jpeg(content, (320, 480, 3), target)
    assert not decode_smaller_jpeg(content[:-2000], FULL, target)
    assert not decode_smaller_jpeg(cv2.imencode(".png", target)[1].tobytes(), FULL, target)
    assert not target.any()


@pytest.mark.parametrize("size", [(0, 5), (321, 5), (5, 241), (5,), (1, 2, 3), (5.0, 5), "55", 5, (True, 5), None])
def test_other_sizes_are_refused(size):
    """Sizes are two whole numbers within the picture."""
    with pytest.raises(UsageError, match="a size of"):
        need_smaller(size, (320, 240))
    assert need_smaller([320, 1], (320, 240)) == (320, 1)
