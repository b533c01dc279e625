"""Shadows on the gel: pressed-in parts block the lights for the parts behind them."""

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
"""Largest distance along the gel, m, at which an obstacle casts a shadow."""
STEPS = 12
"""Number of distances that are tried up to ``REACH``."""
SOFT_DEPTH = 5e-5
"""Height, m, by which an obstacle must exceed the ray for a full shadow; lights have a size."""
ELEVATIONS = (0.15, 0.25, 0.35, 0.45, 0.6)
"""Elevations of the lights above the gel's plane, rad, that are tried."""
ELEVATION = 0.4
"""Elevation, rad, where no shadow was found."""


@dataclass(frozen=True)
class Shadows:
    """Direction of each colour channel's light, and the share of it that a shadow removes.

    Parameters
    ----------
    azimuths : (3,) rad
        Directions towards the lights of R, G and B, counted from columns to rows.
    elevation : rad
        Angle of all lights above the gel's plane.
    strengths : (3,)
        Share of the background's grey level that a full shadow removes, 0 to 1.
    is_planar : bool
        Shadows fall onto the flat gel (FOTS); otherwise onto the deformed one (Taxim).
    """

    azimuths: tuple[float, float, float]
    elevation: float
    strengths: tuple[float, float, float]
    is_planar: bool = False

    def darkening(self, indentation: Any, view: View) -> Map:
        """Share (rows, columns, 3) of the background that shadows remove, by channel.

        ``indentation`` (rows, columns) is in metres.
        """
        shadows = [cast_shadow(indentation, view, azimuth, self.elevation, self.is_planar) for azimuth in self.azimuths]
        return np.stack(shadows, axis=-1) * np.array(self.strengths, np.float32)


def cast_shadow(indentation: Any, view: View, azimuth: float, elevation: float, is_planar: bool = False) -> Map:
    """Shadow (rows, columns) of one light: 0 where lit, 1 in full shadow.

    Parameters
    ----------
    indentation : (rows, columns) m
        Lights are on the camera's side, so that pressed-in parts block them.
    view : View
        Gives the distance between pixels.
    azimuth, elevation : rad
        Direction towards the light.
    is_planar : bool
        The shadow falls onto the flat gel instead of the deformed one, and the contact itself has none.
    """
    height = np.asarray(indentation, np.float32)
    receiver = np.zeros_like(height) if is_planar else height
    across, down = view.pitches
    blocked = np.zeros_like(height)
    for length in np.linspace(REACH / STEPS, REACH, STEPS):
        shift = np.array(
            [[1, 0, np.cos(azimuth) * length / across], [0, 1, np.sin(azimuth) * length / down]], np.float32
        )
        # inverse map: each pixel reads the height at this distance towards the light
        obstacle: Any = cv2.warpAffine(
            height,
            shift,
            height.shape[::-1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        np.maximum(blocked, obstacle - receiver - np.float32(length * np.tan(elevation)), out=blocked)
    shadow = np.clip(blocked / np.float32(SOFT_DEPTH), 0.0, 1.0)
    if is_planar:
        shadow[height > SOFT_DEPTH] = 0.0  # the contact itself is not flat; the colour table covers it
    return shadow


def light_azimuths(table: TaximTable) -> tuple[float, float, float]:
    """Azimuth of the light of R, G and B, rad: opposite to the direction of slopes that a table makes brightest.

    The direction is the phase of the first harmonic of the table's constant terms.
    """
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
    """Fit elevation and strengths of shadows to the residual of a colour model, in least squares.

    Parameters
    ----------
    residuals : n of (rows, columns, 3)
        Picture minus the prediction of the model without shadows, grey levels.
    backgrounds : n of (rows, columns, 3)
        Pictures without contact, grey levels.
    indentations : n of (rows, columns) m
        Depth at each pixel.
    view : View
        Gives the distance between pixels.
    azimuths : (3,) rad
        Directions towards the lights of R, G and B.
    is_planar : bool
        Shadows fall onto the flat gel instead of the deformed one.
    """
    best, smallest_change = Shadows(azimuths, ELEVATION, (0.0, 0.0, 0.0), is_planar), 0.0
    for elevation in ELEVATIONS:
        overlap, power = np.zeros(3), np.zeros(3)
        for residual, background, indentation in zip(residuals, backgrounds, indentations, strict=True):
            darkening = (
                Shadows(azimuths, elevation, (1.0, 1.0, 1.0), is_planar).darkening(indentation, view) * background
            )
            overlap += (np.asarray(residual, np.float64) * darkening).sum(axis=(0, 1))
            power += np.square(darkening, dtype=np.float64).sum(axis=(0, 1))
        share = np.clip(-overlap / np.maximum(power, 1e-9), 0.0, 1.0)
        change = float((2 * share * overlap + share**2 * power).sum())  # of the squared residual
        if change < smallest_change:
            red, green, blue = share.tolist()
            best, smallest_change = Shadows(azimuths, elevation, (red, green, blue), is_planar), change
    return best
