"""Closed forms of the metrics of pairs: pictures, meshes, forces."""

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio

from tactiledata.errors import UsageError
from tactiledata.metrics.force_error import FORCE_ERROR, root_mean_square
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY, gradient_error, l1, mse, psnr, ssim
from tactiledata.metrics.mesh_distance import euclidean, rmse
from tactiledata.metrics.mesh_distance import l1 as mesh_l1


@pytest.fixture
def pictures():
    """Three pairs of pictures."""
    rng = np.random.default_rng(0)
    true = rng.integers(0, 200, (3, 30, 26, 3)).astype(np.uint8)
    return np.clip(true + rng.normal(0, 9, true.shape), 0, 255).astype(np.uint8), true


def test_a_constant_shift_of_grey_levels():
    """l1 is the shift, MSE its square, PSNR 20 log10(255 / shift)."""
    true = np.full((2, 12, 10, 3), 90, np.uint8)
    assert l1(true + np.uint8(6), true) == pytest.approx(6)
    assert mse(true + np.uint8(6), true) == pytest.approx(36)
    assert psnr(true + np.uint8(6), true) == pytest.approx(20 * np.log10(255 / 6))


def test_differences_do_not_wrap():
    """Black against white is 255 levels, not 1."""
    black, white = np.zeros((1, 9, 9, 3), np.uint8), np.full((1, 9, 9, 3), 255, np.uint8)
    assert l1(black, white)[0] == l1(white, black)[0] == 255


def test_psnr_agrees_with_scikit_image(pictures):
    """The PSNR of each frame is that of scikit-image."""
    expected = [peak_signal_noise_ratio(true, ours, data_range=255) for ours, true in zip(*pictures, strict=True)]
    np.testing.assert_allclose(psnr(*pictures), expected, rtol=1e-6)


def test_ssim_of_constant_pictures():
    """Without any structure SSIM is its luminance term, (2ab + c) / (a² + b² + c)."""
    one, other = np.full((1, 12, 12, 3), 100, np.uint8), np.full((1, 12, 12, 3), 140, np.uint8)
    c = (0.01 * 255) ** 2
    assert ssim(one, other)[0] == pytest.approx((2 * 100 * 140 + c) / (100**2 + 140**2 + c))


def test_gradient_errors_of_ramps_and_of_a_line():
    """A ramp along x of 2 levels a px errs by 2 / 2, one along y too; an offset by nothing; a softened line at it."""
    flat = np.full((1, 8, 10, 3), 50, np.uint8)
    along = flat + (2 * np.arange(10, dtype=np.uint8))[None, None, :, None]
    down = flat + (2 * np.arange(8, dtype=np.uint8))[None, :, None, None]
    assert gradient_error(along, flat) == pytest.approx(1.0)
    assert gradient_error(flat, down) == pytest.approx(1.0)
    assert gradient_error(along + np.uint8(40), along) == pytest.approx(0.0)
    # a line of 60 levels drawn as 20 levels over three columns: off by 20, -40, 20 in columns 4 to 6
    sharp, soft = flat.copy(), flat.copy()
    sharp[:, :, 5] += 60
    soft[:, :, 4:7] += 20
    # central differences of (0, 20, -40, 20, 0): 10, -20, 0, 20, -10 in columns 3 to 7; half of their mean
    assert gradient_error(soft, sharp) == pytest.approx((10 + 20 + 0 + 20 + 10) / 10 / 2)
    with pytest.raises(UsageError, match="pictures of 1 x 9"):
        gradient_error(np.zeros((1, 1, 9, 3), np.uint8), np.zeros((1, 1, 9, 3), np.uint8))


@pytest.mark.parametrize("score", IMAGE_SIMILARITY.scores.values(), ids=lambda score: score.name)
def test_masks(score, pictures):
    """A full mask is the full frame; what is outside does not count; an empty mask has no value."""
    ours, true = pictures
    np.testing.assert_allclose(score(ours, true, np.ones(true.shape[:3], bool)), score(ours, true), rtol=1e-6)
    mask = np.zeros(true.shape[:3], bool)
    mask[:2, 10:18, 9:17] = True
    elsewhere = ours.copy()
    elsewhere[:, :5] = 0  # further from the mask than SSIM's window reaches
    inside = score(ours, true, mask)
    np.testing.assert_array_equal(inside, score(elsewhere, true, mask))
    assert np.isnan(inside[2])
    assert np.isfinite(inside[:2]).all()
    assert (score(elsewhere, true) != score(ours, true)).all()


def test_wrong_masks_are_refused(pictures):
    """A mask of another size, or of numbers, is no mask; pictures of floats are no pictures."""
    with pytest.raises(UsageError, match="mask"):
        l1(*pictures, np.ones((3, 5, 5), bool))
    with pytest.raises(UsageError, match="mask"):
        ssim(*pictures, np.ones((3, 30, 26)))
    with pytest.raises(UsageError, match="uint8"):
        l1(pictures[0].astype(float), pictures[1])


def test_a_shifted_mesh():
    """Nodes moved by (3, 4, 0) um are off by Euclidean 5 um, RMSE 5 / sqrt 3, l1 7/3; moving both changes nothing."""
    true = np.random.default_rng(1).normal(0, 1e-3, (2, 50, 3))
    moved = true + np.array([3e-6, 4e-6, 0])
    assert euclidean(moved, true) == pytest.approx(5e-3)
    assert rmse(moved, true) == pytest.approx(5e-3 / np.sqrt(3))
    assert mesh_l1(moved, true) == pytest.approx(7e-3 / 3)
    assert rmse(moved + 0.1, true + 0.1) == pytest.approx(rmse(moved, true))


def test_force_errors_by_axis():
    """Each axis has its own error; the norm's error is that of the norms."""
    true, ours = np.array([[3.0, 0, 4], [0, 0, 2]]), np.array([[0.0, 0, 4], [0, 1, 2]])
    found = {name: score(ours, true) for name, score in FORCE_ERROR.scores.items()}
    np.testing.assert_allclose(found["fx"], [3, 0])
    np.testing.assert_allclose(found["fy"], [0, 1])
    np.testing.assert_allclose(found["fz"], [0, 0])
    np.testing.assert_allclose(found["norm"], [1, np.sqrt(5) - 2])
    assert root_mean_square(found["fx"]) == pytest.approx(3 / np.sqrt(2))
