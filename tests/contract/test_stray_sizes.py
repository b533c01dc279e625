"""Which sizes of images are strays among the others, and how a size is said."""

import pytest

from tactiledata.contract.image_sizes import share_words, stray_sizes, words_of

USUAL, OTHER, THIRD = (320, 240), (3200, 2400), (640, 480)


@pytest.mark.parametrize(
    ("counts", "strays"),
    [
        ({}, set()),
        ({USUAL: 1}, set()),
        ({USUAL: 1, OTHER: 1}, set()),  # half is not more than half
        ({USUAL: 2, OTHER: 1}, {OTHER}),  # one image is a stray, whatever its share
        ({USUAL: 3, OTHER: 2}, set()),
        ({USUAL: 18, OTHER: 2}, {OTHER}),  # a tenth
        ({USUAL: 17, OTHER: 3}, set()),
        ({USUAL: 10, OTHER: 1, THIRD: 9}, set()),  # of 20 images half have one size
        ({USUAL: 11, OTHER: 1, THIRD: 8}, {OTHER}),
    ],
)
def test_strays_are_a_tenth_at_most_beside_a_majority(counts, strays):
    """One image or a tenth is a stray where more than half have one size; otherwise nothing is."""
    assert stray_sizes(counts) == strays


def test_sizes_are_said_as_rows_by_columns():
    """Rows first; the verb agrees with the number of images."""
    assert words_of((3200, 2400)) == "3200 x 2400"
    assert share_words(1, 40, OTHER) == "1 of 40 images is 3200 x 2400"
    assert share_words(2, 40, OTHER) == "2 of 40 images are 3200 x 2400"
