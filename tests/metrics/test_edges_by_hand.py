"""Edges of the metrics of pictures and vectors: bins, windows, masks of some samples, words of refusals."""

import sys

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import image_masks, image_pairs, number_pairs
from tactiledata.metrics.force_error import FORCE_ERROR
from tactiledata.metrics.histogram import histogram_correlation, histogram_intersection, histograms
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY, l1, ssim
from tactiledata.metrics.mesh_distance import rmse


def columns(*levels):
    """One picture of 8 x n pixels, a column of each level."""
    return np.repeat(np.repeat(np.array(levels, np.uint8)[None, None, :, None], 8, 1), 3, 3)


@pytest.mark.parametrize(("level", "place"), [(0, 0), (7, 0), (8, 1), (15, 1), (16, 2), (247, 30), (248, 31)])
def test_a_bin_is_eight_levels_wide(level, place):
    """There are 32 bins from 0 to 255."""
    found = histograms(columns(level))
    assert found.shape == (1, 3, 32)
    assert (found[0, :, place] == 1).all()


def test_channels_have_their_own_histograms():
    """Red 0, green 100 and blue 200 fill the bins 0, 12 and 25."""
    picture = np.broadcast_to(np.array([0, 100, 200], np.uint8), (1, 4, 4, 3))
    assert histograms(picture).argmax(axis=2).tolist() == [[0, 12, 25]]


def test_intersection_and_correlation_by_hand():
    """A quarter black and three quarters white, against black and against the mean of black and white."""
    picture, black, white = columns(0, 255, 255, 255), columns(0), columns(255)
    assert histogram_intersection(picture, black) == pytest.approx([0.25])
    assert histogram_intersection(picture, np.concatenate([black[:, :, :1], white[:, :, :1]])) == pytest.approx([0.75])
    # shares less 1/32; products over norms: (0.25 - 1/32) / sqrt(0.625 - 1/32) / sqrt(1 - 1/32)
    assert histogram_correlation(picture, black) == pytest.approx([0.21875 / np.sqrt(0.59375 * 0.96875)])


def test_a_histogram_without_structure_is_like_none():
    """All bins alike have no deviation: the correlation is 0, not undefined."""
    even = columns(*range(4, 256, 8))
    assert histogram_correlation(even, columns(0)).tolist() == [0.0]
    assert histogram_correlation(columns(0), even).tolist() == [0.0]


@pytest.mark.parametrize("score", IMAGE_SIMILARITY.scores.values(), ids=lambda score: score.name)
def test_a_sample_behind_one_without_a_mask_has_a_value(score):
    """Of three samples the middle one has an empty mask: it alone is NaN."""
    rng = np.random.default_rng(0)
    ours, theirs = (rng.integers(0, 256, (3, 12, 14, 3)).astype(np.uint8) for _ in range(2))
    mask = np.ones((3, 12, 14), bool)
    mask[1] = False
    found = score(ours, theirs, mask)
    assert np.isnan(found).tolist() == [False, True, False]
    np.testing.assert_allclose(found[[0, 2]], score(ours, theirs)[[0, 2]], rtol=1e-6)


def test_ssim_needs_seven_pixels_a_side():
    """7 x 7 has one place; six pixels either way are refused with the size. The rim of three pixels has no value."""
    assert ssim(np.zeros((2, 7, 7, 3), np.uint8), np.zeros((2, 7, 7, 3), np.uint8)) == pytest.approx([1, 1])
    for height, width in ((6, 9), (9, 6)):
        batch = np.zeros((2, height, width, 3), np.uint8)
        with pytest.raises(UsageError, match=f"pictures of {height} x {width}; expected 7 px a side"):
            ssim(batch, batch)
    batch = np.zeros((1, 9, 9, 3), np.uint8)
    rim = np.ones((1, 9, 9), bool)
    rim[:, 3:-3, 3:-3] = False
    assert np.isnan(ssim(batch, batch, rim)).all()
    rim[:, 3, 3] = True
    assert ssim(batch, batch, rim) == pytest.approx([1])


def test_without_scikit_image_it_is_named(monkeypatch):
    """The error says what is missing and how it is installed."""
    monkeypatch.setitem(sys.modules, "skimage.metrics", None)
    batch = np.zeros((1, 9, 9, 3), np.uint8)
    with pytest.raises(UsageError, match=r"SSIM needs scikit-image.*pip install"):
        ssim(batch, batch)


@pytest.mark.parametrize("dtype", ["i1", "u1", "f8", "M8[s]", "O"])
def test_a_mask_of_another_type_is_refused(dtype):
    """Numbers, moments and objects are no mask; the message has the shape and the type, and those that fit."""
    batch = np.zeros((2, 4, 5, 3), np.uint8)
    with pytest.raises(UsageError, match=r"a mask of shape \(2, 4, 5\), .*expected \(2, 4, 5\) bool"):
        image_masks(np.zeros((2, 4, 5), dtype), batch)


def test_pictures_of_two_sizes_are_no_pairs():
    """Both shapes are said."""
    one, other = np.zeros((2, 4, 5, 3), np.uint8), np.zeros((2, 5, 4, 3), np.uint8)
    with pytest.raises(UsageError, match=r"of shape \(2, 4, 5, 3\) beside true ones of \(2, 5, 4, 3\)"):
        image_pairs(one, other, None)
    assert l1(one, one).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("shape", [(3,), (4, 2), (4, 4), (3, 3, 3), (3, 2), ()])
def test_forces_have_three_components(shape):
    """Of one or three axes, or with two or four components, they are refused; the axes that fit are named."""
    with pytest.raises(UsageError, match=r"both \(n, 3\)"):
        number_pairs(np.zeros(shape), np.zeros(shape), ("n", "3"))


@pytest.mark.parametrize("shape", [(4, 3), (4, 3, 2), (4, 3, 4), (1, 4, 3, 3)])
def test_meshes_have_three_components(shape):
    """Three vertices do not stand for three components."""
    with pytest.raises(UsageError, match=r"both \(n, vertices, 3\)"):
        rmse(np.zeros(shape), np.zeros(shape))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_sample_that_is_not_finite_is_named(value):
    """The second of five samples is named, of the predicted ones and of the true ones, where the fourth is bad too."""
    good, bad = np.ones((5, 2, 3)), np.ones((5, 2, 3))
    bad[1, 1, 2] = bad[3, 0, 0] = value
    for ours, theirs, what in ((bad, good, "predicted"), (good, bad, "true"), (bad, bad, "predicted")):
        with pytest.raises(UsageError, match=f"{what} holds NaN or infinity, first in sample 1;"):
            rmse(ours, theirs)


def test_best_values_of_every_score():
    """What identical things get: 0, but for five likenesses and what is kept of a touch."""
    best = {f"{name}.{score.name}": score.best for name in METRICS for score in METRICS[name].scores.values()}
    high = {name: value for name, value in best.items() if value}
    assert high == {
        "image_similarity.ssim": 1.0,
        "image_similarity.psnr": np.inf,
        "histogram.histogram_intersection": 1.0,
        "histogram.histogram_correlation": 1.0,
        "embedding.knn_mixing": 1.0,
        "kept_touch.strength_kept": 1.0,
        "kept_touch.change_correlation": 1.0,
        "kept_touch.mask_overlap": 1.0,
    }
    assert list(FORCE_ERROR.scores) == ["fx", "fy", "fz", "norm"]
