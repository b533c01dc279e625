"""Parts of the search for copies whose result is worked out by hand."""

import numpy as np
import pytest

from tactiledata.splits.copies import adjusted, brightness_fit, difference, middle_of
from tactiledata.splits.options import SplitOptions
from tactiledata.splits.report import Count, SplitReport


@pytest.mark.parametrize(
    ("shape", "rows", "columns"),
    [
        # (320 - 192) / 2 = 64 and (240 - 144) / 2 = 48 are multiples of 16
        ((320, 240), (64, 256), (48, 192)),
        # 54 rows and 28 columns are rounded down to 48 and 16
        ((300, 200), (48, 240), (16, 160)),
        # smaller than the crop: all of it
        ((100, 80), (0, 100), (0, 80)),
    ],
)
def test_the_middle_lies_on_the_grid_of_compression_blocks(shape, rows, columns):
    """The middle has 192 x 144 pixels at most, and begins at a multiple of 16."""
    image = np.random.default_rng(0).integers(0, 256, (*shape, 3), dtype=np.uint8)
    np.testing.assert_array_equal(middle_of(image), image[slice(*rows), slice(*columns)])


def test_saturated_colours_have_no_say_in_the_brightness():
    """Colours at or beyond 12 and 243 are left out, in either picture: they would bend the line."""
    rng = np.random.default_rng(1)
    original = rng.uniform(20, 200, 400).astype(np.float32)
    other = 1.1 * original + 5
    for low, high in ((0.0, 250.0), (250.0, 0.0), (5.0, 12.0), (243.0, 255.0), (100.0, 250.0), (12.0, 100.0)):
        one = np.concatenate([original, np.full(300, low, np.float32)])
        two = np.concatenate([other, np.full(300, high, np.float32)])
        assert brightness_fit(one, two) == pytest.approx((1.1, 5.0), abs=1e-3)


def test_too_few_colours_or_too_alike_ones_say_nothing():
    """Below 100 colours, or where they spread by less than a grey level, the brightness is taken as it is."""
    line = np.linspace(50, 200, 99, dtype=np.float32)
    assert brightness_fit(line, 2 * line - 30) == (1.0, 0.0)
    flat = np.full(500, 80, np.float32)
    assert brightness_fit(flat, flat + 9) == (1.0, 0.0)
    line = np.linspace(50, 100, 100, dtype=np.float32)
    assert brightness_fit(line, 2 * line - 30) == pytest.approx((2.0, -30.0), abs=1e-3)


def test_brightness_is_rounded_and_clipped():
    """10 x 1.25 + 0.2 is 12.7, which is 13; 250 x 1.25 is beyond white; 2 - 5 is beyond black."""
    assert adjusted(np.array([10, 250], np.uint8), 1.25, 0.2).tolist() == [13, 255]
    assert adjusted(np.array([2], np.uint8), 1.0, -5.0).tolist() == [0]


def test_a_difference_is_that_of_luma():
    """Red 10 levels apart are 2.99 levels of luma (ITU-R BT.601), green 5.87, blue 1.14."""
    black = np.zeros((4, 4, 3), np.uint8)
    for channel, luma in enumerate((2.99, 5.87, 1.14)):
        other = black.copy()
        other[..., channel] = 10
        assert difference(black, other) == pytest.approx(luma, abs=0.005)


def test_a_split_of_nothing_is_reported():
    """Shares of no trajectories are 0.0 %, not a division by zero."""
    counts = {part: Count(0, 0) for part in ("train", "val", "test")}
    report = SplitReport("empty", SplitOptions(), {}, counts, (), ())
    assert sum("(0.0%)" in line for line in report.lines()) == 3
