"""Similarity of two pictures: l1, MSE, SSIM, PSNR and error of gradients, on the full frame or in a contact mask."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.extras import missing_package
from tactiledata.errors import UsageError
from tactiledata.metrics.base import Score, Values, image_pairs, metric

WINDOW = 7
"""Side, px, of the square in which SSIM compares: the default of scikit-image."""
RANGE = 255.0
"""Difference, grey levels, of white and black."""


def l1(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean absolute difference (n,) of pictures, grey levels.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair.
    mask : (n, H, W) bool, optional
        Restricts each pair to the pixels of its contact; a pair with an empty mask is NaN.
    """
    return _mean_of(np.abs, predicted, true, mask)


def mse(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean squared difference (n,) of pictures, grey levels squared.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair.
    mask : (n, H, W) bool, optional
        Restricts each pair to the pixels of its contact; a pair with an empty mask is NaN.
    """
    return _mean_of(np.square, predicted, true, mask)


def psnr(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Peak signal-to-noise ratio (n,) of pictures, dB; infinite for pictures that are equal.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair.
    mask : (n, H, W) bool, optional
        Restricts each pair to the pixels of its contact; a pair with an empty mask is NaN.
    """
    error = mse(predicted, true, mask)
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(RANGE) - 10.0 * np.log10(error)


def ssim(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Structural similarity (n,), 1 for equal pictures, mean over the channels.

    It is that of scikit-image with its defaults (uniform window of 7 px, sample covariance, a border of 3 px left out).
    Inside a mask it is the mean of the same map over the pixels of the mask, also without the border, so that a full
    mask gives the value of the full frame.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair.
    mask : (n, H, W) bool, optional
        Restricts each pair to the pixels of its contact; a pair with an empty mask is NaN.

    Raises
    ------
    UsageError
        Pictures smaller than the window, or scikit-image is not installed.
    """
    ours, theirs, inside = image_pairs(predicted, true, mask)
    if min(ours.shape[1:3]) < WINDOW:
        raise UsageError(f"pictures of {ours.shape[1]} x {ours.shape[2]}", f"{WINDOW} px a side for SSIM", "")
    similarity = _structural_similarity()
    border = WINDOW // 2
    values = np.full(len(ours), np.nan)
    for row, (picture, truth) in enumerate(zip(ours, theirs, strict=True)):
        where = _cropped(inside, row, border)
        if where is not None and not where.any():
            continue
        mean, full = similarity(picture, truth, win_size=WINDOW, data_range=RANGE, channel_axis=2, full=True)
        values[row] = mean if where is None else full[border:-border, border:-border][where].mean()
    return values


def gradient_error(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean absolute difference (n,) of the gradients of pictures, grey levels per px; a constant offset counts nothing.

    It is the mean over rows, columns and channels of the absolute values of central differences (`numpy.gradient`) of
    the difference of two pictures. A picture that is softer than the truth errs at every edge of it.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair, of at least two pixels a side.
    mask : (n, H, W) bool, optional
        Restricts each pair to the pixels of its contact; a pair with an empty mask is NaN.

    Raises
    ------
    UsageError
        Pictures of one pixel a side.
    """
    shape = np.shape(predicted)
    if len(shape) == 4 and min(shape[1:3]) < 2:
        raise UsageError(f"pictures of {shape[1]} x {shape[2]}", "2 px a side for gradients", "")
    return _mean_of(_steepness, predicted, true, mask)


def _steepness(difference: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean (H, W, 3) of the absolute central differences along rows and along columns."""
    down, along = np.gradient(difference, axis=(0, 1))
    steepness: NDArray[np.float32] = (np.abs(down) + np.abs(along)) / 2
    return steepness


def _cropped(inside: NDArray[np.bool_] | None, row: int, border: int) -> NDArray[np.bool_] | None:
    """Return the mask of a row without the border, px; None where there are no masks."""
    return None if inside is None else inside[row, border:-border, border:-border]


def _mean_of(power: Any, predicted: Any, true: Any, mask: Any) -> Values:
    """Mean (n,) over pixels and channels of a function of the difference of each pair."""
    ours, theirs, inside = image_pairs(predicted, true, mask)
    values = np.full(len(ours), np.nan)
    for row, (picture, truth) in enumerate(zip(ours, theirs, strict=True)):
        difference = power(picture.astype(np.float32) - truth)
        if inside is None:
            values[row] = difference.mean(dtype=np.float64)
        elif inside[row].any():
            values[row] = difference[inside[row]].mean(dtype=np.float64)
    return values


def _structural_similarity() -> Any:
    """Return the function of scikit-image, or refuse where it is not installed."""
    try:
        from skimage.metrics import structural_similarity
    except ImportError as error:
        raise missing_package("skimage", "SSIM") from error
    return structural_similarity


IMAGE_SIMILARITY = metric(
    "image_similarity",
    "how alike two pictures are, pixel by pixel",
    "images",
    [
        Score("l1", "l1", "grey levels", "lower", 0.0, l1),
        Score("mse", "MSE", "grey levels²", "lower", 0.0, mse),
        Score("ssim", "SSIM", "", "higher", 1.0, ssim),
        Score("psnr", "PSNR", "dB", "higher", np.inf, psnr),
        Score("gradient_error", "error of gradients", "grey levels/px", "lower", 0.0, gradient_error),
    ],
)
