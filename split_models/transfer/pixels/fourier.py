"""Fourier domain adaptation: low frequencies take the amplitude of the target background, and all phases are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray

WINDOW = 0.01
"""Half the side of the square of exchanged frequencies, as a share of the picture's shorter side (beta of the source).

It is the smallest that the source tries (0.01, 0.05, 0.09), because larger ones leave ringing."""


def swap_amplitude(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Pictures with the target background's amplitude at low frequencies.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background : (H, W, 3) float32
        Not used.
    target_background : (H, W, 3) float32, grey levels
        The target without contact.
    """
    goal = np.abs(fft.rfft2(target_background, axes=(0, 1)))
    spectrum = fft.rfft2(images, axes=(1, 2))
    rows, columns = low_frequencies(images.shape[1:3])
    inside = np.ix_(np.arange(len(images)), rows, columns)
    low = spectrum[inside]
    phase = np.exp(1j * np.angle(low))
    spectrum[inside] = goal[np.ix_(rows, columns)] * phase
    return np.asarray(fft.irfft2(spectrum, s=images.shape[1:3], axes=(1, 2)), dtype=np.float32)


def low_frequencies(shape: tuple[int, int]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of a half spectrum (H, W // 2 + 1) whose amplitudes are exchanged; ``shape`` is (H, W)."""
    reach = max(1, int(np.floor(WINDOW * min(shape))))
    rows = np.unique(np.arange(-reach, reach + 1) % shape[0])
    return rows, np.arange(min(reach, shape[1] // 2) + 1)


FOURIER = PixelTransfer(
    "fourier",
    "Fourier amplitude swap (FDA)",
    "Yang and Soatto, FDA: Fourier Domain Adaptation for Semantic Segmentation, CVPR 2020",
    swap_amplitude,
)
