"""Shadows on the gel: what stands up towards the lights keeps them from what lies behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.optics.taxim import TaximTable
from tactiledata.optics.view import View

Map = NDArray[np.float32]

REACH = 3e-3
"""m along the gel up to which something in the way of a light is looked for."""
STEPS = 12
"""Places along that way."""
SOFT_DEPTH = 5e-5
"""m by which a light must be missed for a full shadow: lights have a size."""
ELEVATIONS = (0.15, 0.25, 0.35, 0.45, 0.6)
"""rad above the gel's plane at which lights are looked for."""
ELEVATION = 0.4
"""rad, where nothing was fitted."""


@dataclass(frozen=True)
class Shadows:
    """Where each channel's light stands, and how much of it a shadow takes.

    Parameters
    ----------
    azimuths : (3,)
        rad, towards the light, from columns to rows, of R, G and B.
    elevation : rad
    strengths : (3,)
        Share of the background's grey level that a full shadow takes, 0 to 1.
    is_planar : bool
        Shadows fall onto the flat gel (FOTS); otherwise onto the deformed one (Taxim).
    """

    azimuths: tuple[float, float, float]
    elevation: float
    strengths: tuple[float, float, float]
    is_planar: bool = False

    def darkening(self, indentation: Any, view: View) -> Map:
        """Share (rows, columns, 3) of the background that shadows take, by channel."""
        cast = [cast_shadow(indentation, view, azimuth, self.elevation, self.is_planar) for azimuth in self.azimuths]
        return np.stack(cast, axis=-1) * np.array(self.strengths, np.float32)


def cast_shadow(indentation: Any, view: View, azimuth: float, elevation: float, is_planar: bool = False) -> Map:
    """Shadow (rows, columns) of one light: 0 lit, 1 in full shadow.

    Parameters
    ----------
    indentation : (rows, columns), metres
        Lights are on the camera's side, so that what is pressed in stands in their way.
    view : View
    azimuth, elevation : rad
        Towards the light.
    is_planar : bool
    """
    height = np.asarray(indentation, np.float32)
    receiver = np.zeros_like(height) if is_planar else height
    across, down = view.pitches
    blocked = np.zeros_like(height)
    for length in np.linspace(REACH / STEPS, REACH, STEPS):
        shift = np.array(
            [[1, 0, np.cos(azimuth) * length / across], [0, 1, np.sin(azimuth) * length / down]], np.float32
        )
        # the inverse map: each pixel reads what stands between it and the light
        in_the_way: Any = cv2.warpAffine(
            height,
            shift,
            height.shape[::-1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        np.maximum(blocked, in_the_way - receiver - np.float32(length * np.tan(elevation)), out=blocked)
    shadow = np.clip(blocked / np.float32(SOFT_DEPTH), 0.0, 1.0)
    if is_planar:
        shadow[height > SOFT_DEPTH] = 0.0  # the contact itself is no plane; the table knows it
    return shadow


def light_azimuths(table: TaximTable) -> tuple[float, float, float]:
    """Where the lights of a table stand, rad: opposite to the brightest slope, by each channel's first harmonic."""
    angles, directions = table.bins
    steep = table.coefficients[angles // 8 : angles // 2, :-1, :, 5].mean(axis=0)
    theta = (np.arange(directions - 1) + 0.5) / (directions - 1) * 2 * np.pi - np.pi
    brightest = np.angle((steep * np.exp(1j * theta)[:, None]).sum(axis=0))
    red, green, blue = np.angle(np.exp(1j * (brightest + np.pi)))
    return float(red), float(green), float(blue)


def fit_shadows(
    residuals: Sequence[Any],
    backgrounds: Sequence[Any],
    indentations: Sequence[Any],
    view: View,
    azimuths: tuple[float, float, float],
    is_planar: bool = False,
) -> Shadows:
    """The elevation and strengths that explain best what a colour model leaves over.

    Parameters
    ----------
    residuals : n of (rows, columns, 3)
        Picture minus what the model without shadows predicts, grey levels.
    backgrounds : n of (rows, columns, 3)
    indentations : n of (rows, columns), metres
    view, azimuths, is_planar
        See ``Shadows``.
    """
    best, least = Shadows(azimuths, ELEVATION, (0.0, 0.0, 0.0), is_planar), 0.0
    for elevation in ELEVATIONS:
        overlap, size = np.zeros(3), np.zeros(3)
        for residual, background, indentation in zip(residuals, backgrounds, indentations, strict=True):
            dark = Shadows(azimuths, elevation, (1.0, 1.0, 1.0), is_planar).darkening(indentation, view) * background
            overlap += (np.asarray(residual, np.float64) * dark).sum(axis=(0, 1))
            size += np.square(dark, dtype=np.float64).sum(axis=(0, 1))
        share = np.clip(-overlap / np.maximum(size, 1e-9), 0.0, 1.0)
        change = float((2 * share * overlap + share**2 * size).sum())  # of the squared residual
        if change < least:
            red, green, blue = share.tolist()
            best, least = Shadows(azimuths, elevation, (red, green, blue), is_planar), change
    return best
