"""Runs of images cover all of them in order, each within both limits."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.image_batches import image_batches


@given(st.lists(st.integers(0, 50), max_size=40), st.integers(1, 8), st.integers(1, 100))
def test_runs_cover_all_within_both_limits_and_are_as_long_as_they_may(pixels, most_images, most_pixels):
    """Each run ends where one image more would break a limit; only a single image may have more pixels."""
    runs = list(image_batches(np.array(pixels, np.int64), most_images, most_pixels))
    assert [place for start, stop in runs for place in range(start, stop)] == list(range(len(pixels)))
    for start, stop in runs:
        assert stop - start <= most_images
        assert stop - start == 1 or sum(pixels[start:stop]) <= most_pixels
        is_full = stop - start == most_images or sum(pixels[start : stop + 1]) > most_pixels
        assert stop == len(pixels) or is_full
