"""How much of a touch is kept, by hand: strength, correlation, mask overlap, and what must not count."""

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics.kept_touch import change_of, correlation, overlap, strength, touched


@pytest.fixture(scope="module")
def square():
    """A change of 40 grey levels in one channel inside a square of 40 px, (1, 160, 120, 3)."""
    change = np.zeros((1, 160, 120, 3), np.float32)
    change[0, 60:100, 40:80, 0] = 40.0
    return change


def test_a_touch_that_stays_is_kept_whole(square):
    """The recorded change itself scores 1 in all three."""
    for score in (strength, correlation, overlap):
        assert score(square, square) == pytest.approx([1.0])


@pytest.mark.parametrize("share", [0.5, 1.5])
def test_strength_is_the_share_that_is_left(square, share):
    """Half the change is half the strength, more is more; where it lies stays correlated."""
    assert strength(share * square, square) == pytest.approx([share])
    assert correlation(share * square, square) == pytest.approx([1.0])


def test_a_vanished_touch_scores_zero(square):
    """No change at all has strength, correlation and overlap 0: a vanished touch is the worst, and not left out."""
    for score in (strength, correlation, overlap):
        assert score(np.zeros_like(square), square).tolist() == [0.0]


def test_a_touch_elsewhere_is_not_kept(square):
    """The same square at another place overlaps nowhere and has no strength where the touch was."""
    moved = np.roll(square, 60, axis=1)
    assert strength(moved, square).tolist() == [0.0]
    assert overlap(moved, square).tolist() == [0.0]
    assert correlation(moved, square)[0] < 0.0


def test_colours_may_follow_the_light(square):
    """A change that goes to another channel is kept, since only magnitudes are compared."""
    blue = square[..., ::-1]
    for score in (strength, correlation, overlap):
        assert score(blue, square) == pytest.approx([1.0])


def test_noise_is_no_touch(square):
    """Camera noise of 4 grey levels moves neither mask, and alone it is no touch: all three have no value."""
    noise = np.random.default_rng(0).normal(0.0, 4.0, square.shape).astype(np.float32)
    assert overlap(square + noise, square)[0] > 0.95
    assert not touched(noise).any()
    for score in (strength, correlation, overlap):
        assert np.isnan(score(square, noise)).all()


def test_masks_overlap_as_their_areas():
    """Two squares of which one is half of the other have an overlap of half, to the width of the blur."""
    whole = np.zeros((1, 160, 120, 3), np.float32)
    whole[0, 40:120, 20:100] = 40.0
    half = whole.copy()
    half[0, 40:80] = 0.0
    assert overlap(half, whole)[0] == pytest.approx(0.5, abs=0.03)


def test_what_does_not_fit_is_refused(square):
    """Other shapes are errors that say both."""
    with pytest.raises(UsageError, match="beside"):
        strength(square[:, :80], square)
    with pytest.raises(UsageError, match="background"):
        change_of(np.zeros((1, 8, 8, 3), np.uint8), np.zeros((8, 9, 3), np.uint8))


def test_a_change_is_the_difference_of_grey_levels():
    """Pictures of 10 and 200 against a background of 50: -40 and 150, also where they are few and small."""
    background = np.full((4, 5, 3), 50, np.uint8)
    pictures = np.stack([np.full((4, 5, 3), level, np.uint8) for level in (10, 200)])
    changes = change_of(pictures, background)
    assert changes.shape == (2, 4, 5, 3)
    assert [set(change.ravel().tolist()) for change in changes] == [{-40.0}, {150.0}]


@pytest.mark.parametrize("shape", [(5, 3), (4, 5), (1, 4, 5, 3), (5, 4, 3)])
def test_a_background_of_another_size_is_named_beside_the_pictures(shape):
    """Both sizes are told, without the number of pictures."""
    with pytest.raises(UsageError) as refused:
        change_of(np.zeros((2, 4, 5, 3), np.uint8), np.zeros(shape, np.uint8))
    assert f"pictures of shape (4, 5, 3) with a background of {shape};" in str(refused.value)


def test_strength_is_of_all_three_colours(square):
    """A change of 40 in red is as strong as one of 24 in red and 32 in green: both are 40 in magnitude."""
    other = np.zeros_like(square)
    other[..., 0], other[..., 1] = 0.6 * square[..., 0], 0.8 * square[..., 0]
    assert strength(other, square) == pytest.approx([1.0])


def test_how_many_pictures_there_are_moves_no_mask(square):
    """Of 400 pictures, more than a picture has rows, each has the mask that it has alone."""
    assert (touched(np.repeat(square[:, ::4, ::4], 400, axis=0)) == touched(square[:, ::4, ::4])).all()


@pytest.mark.parametrize("shape", [(1, 8, 6, 2), (8, 6, 3), (1, 1, 8, 6, 3), (1, 8, 6, 4)])
def test_changes_of_other_shapes_are_refused(shape):
    """Two changes of one shape are refused where it is not (n, H, W, 3)."""
    for score in (strength, correlation, overlap):
        with pytest.raises(UsageError, match="changes of shape"):
            score(np.ones(shape), np.ones(shape))


def test_where_nothing_was_touched_nothing_can_be_kept(square):
    """A recorded change without a touch is NaN in all three, without a warning, whatever the other shows."""
    for ours in (square, np.zeros_like(square)):
        for score in (strength, correlation, overlap):
            assert np.isnan(score(ours, np.zeros_like(square))).all()


def test_a_mask_is_blurred_alike_along_rows_and_columns():
    """The mask of a change that is turned by a quarter is the turned mask."""
    change = np.zeros((1, 64, 64, 3), np.float32)
    change[0, 20:30, 20:50] = np.random.default_rng(0).uniform(0.0, 40.0, (10, 30, 3))
    mask = touched(change)
    assert mask.any()
    assert not mask.all()
    assert (touched(np.ascontiguousarray(change.transpose(0, 2, 1, 3))) == mask.transpose(0, 2, 1)).all()


def test_a_change_of_8_grey_levels_is_a_touch():
    """The blur keeps a change that is the same everywhere: 8 grey levels are a touch, a little less is none."""
    change = np.zeros((1, 16, 16, 3), np.float32)
    change[..., 1] = 8.0
    assert touched(change).all()
    assert not touched(change * np.float32(0.999)).any()
