"""Calibration of Taxim's table from pictures of known slopes: presses of a ball, or touches with simulated meshes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, distance_transform_edt

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.optics.taxim import TERMS, TaximTable, place_terms, slope_bins

BINS = 125
"""Number of bins of angle and of direction, as in the published tables."""
SPREAD = 2.0
"""Standard deviation, in bins, of the weights with which neighbouring bins are fitted together."""
RIDGE = 1e-3
"""Ridge of the fit, relative to the bin's number of pixels; it keeps terms small that the pixels do not determine."""
LEAST_PIXELS = 6.0
"""Number of pixels (weighted) below which a bin takes its nearest neighbour's quadratic."""
STEEPEST = 0.9
"""Share of a ball's radius up to which its slope is used: near the rim it becomes infinite, and gel does not follow."""


@dataclass(frozen=True)
class CalibrationPress:
    """Change of a picture, with the slopes of the gel where they are known.

    Parameters
    ----------
    change : (rows, columns, 3)
        Picture minus background, grey levels, RGB.
    slopes : (rows, columns, 2)
        Slopes of the indentation, to the next column and row, m/m.
    is_known : (rows, columns), bool
        Mask of pixels whose slopes are known.
    """

    change: NDArray[np.float32]
    slopes: NDArray[np.float32]
    is_known: NDArray[np.bool_]


def ball_press(
    picture: Any, background: Any, centre: tuple[float, float], contact_radius: float, ball: float
) -> CalibrationPress:
    """Slopes and change of colour of a ball's press: inside the contact the gel has the ball's slopes.

    Parameters
    ----------
    picture, background : (rows, columns, 3), uint8 RGB
        The press, and the same unit without contact.
    centre : (column, row) px
        Centre of the contact.
    contact_radius : px
        As annotated; where it exceeds ``STEEPEST`` of the ball's radius it is cut to that.
    ball : px
        The ball's radius.

    Raises
    ------
    UsageError
        Pictures that differ in shape, or a radius that is not positive.
    """
    if np.shape(picture) != np.shape(background) or np.ndim(picture) != 3:
        raise UsageError(f"a picture {np.shape(picture)} and a background {np.shape(background)}", "one shape", "")
    if not (contact_radius > 0 and ball > 0):
        raise UsageError(f"a contact of {contact_radius} px by a ball of {ball} px", "radii above 0", "")
    rows, columns = np.shape(picture)[:2]
    row, column = np.mgrid[:rows, :columns].astype(np.float32)
    across, down = column - np.float32(centre[0]), row - np.float32(centre[1])
    square = across**2 + down**2
    reach = min(contact_radius, STEEPEST * ball)
    is_known = square <= reach**2
    # slope of a sphere, kept finite beyond the part that is used
    depth_slope = -1.0 / np.sqrt(np.maximum(ball**2 - square, (1 - STEEPEST**2) * ball**2 / 2))
    change = np.asarray(picture, np.float32) - np.asarray(background, np.float32)
    slopes = np.stack([across * depth_slope, down * depth_slope], axis=-1)
    return CalibrationPress(change, slopes.astype(np.float32), is_known)


def calibrate(
    presses: Iterable[CalibrationPress], origin: str, *, bins: int = BINS, spread: float = SPREAD, ridge: float = RIDGE
) -> TaximTable:
    """Fit a table to presses, bin by bin, in least squares.

    All pixels of a bin are fitted together with those of its neighbours; a bin with too few pixels takes the nearest
    one's quadratic. Flat gel is set to no change.

    Parameters
    ----------
    presses : iterable of CalibrationPress
        Pictures of one unit.
    origin : str
        Source of the table, for tables and reports.
    bins : int
        Bins of the angle, and of the direction.
    spread : float
        Standard deviation, in bins, of the weights of neighbouring bins; 0 fits each bin alone.
    ridge : float
        Ridge of the fit, relative to the bin's number of pixels.

    Raises
    ------
    UsageError
        No pixel has a known slope.
    """
    normal, right_side, count = np.zeros((bins * bins, 21)), np.zeros((bins * bins, 3 * TERMS)), np.zeros(bins * bins)
    pairs = np.triu_indices(TERMS)
    # sums of the normal equations, by bin
    for press in presses:
        angle, direction = slope_bins(press.slopes, (bins, bins))
        # flat gel is most of a picture and has no change by definition: it must not dominate neighbouring bins
        is_used = press.is_known & (angle > 0)
        terms = place_terms(press.change.shape[:2])[is_used].astype(np.float64)
        colour, angle, direction = press.change[is_used].astype(np.float64), angle[is_used], direction[is_used]
        _add_up(normal, angle * bins + direction, terms[:, pairs[0]] * terms[:, pairs[1]])
        _add_up(right_side, angle * bins + direction, (colour[:, :, None] * terms[:, None, :]).reshape(-1, 3 * TERMS))
        count += np.bincount(angle * bins + direction, minlength=bins * bins)
    if not count.any():
        raise UsageError("no pixel with a known slope", "presses that show a contact", "Are radii in pixels?")
    # share sums among neighbours, solve, and fill bins with too few pixels
    shape = (bins, bins)
    normal, right_side, count = (_spread(sums.reshape(*shape, -1), spread) for sums in (normal, right_side, count))
    coefficients = _solved(normal, right_side, count[..., 0], ridge, pairs)
    coefficients = _filled(coefficients, count[..., 0] >= LEAST_PIXELS)
    coefficients[0] = 0.0
    return TaximTable(coefficients, origin)


def _add_up(sums: Array, place: NDArray[np.intp], values: Array) -> None:
    """Add values (n, c) to the rows ``place`` (n,) of sums, in place; values for the same row add up."""
    for column in range(sums.shape[1]):
        sums[:, column] += np.bincount(place, values[:, column], len(sums))


def _spread(sums: Array, width: float) -> Array:
    """Sums (angles, directions, c) over neighbouring bins with Gaussian weights; directions are cyclic."""
    if width <= 0:
        return sums
    reach = int(np.ceil(3 * width))
    bell = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    cyclic = sums[:, :-1].copy()  # the last direction is the first one again
    cyclic[:, 0] += sums[:, -1]
    cyclic = convolve1d(convolve1d(cyclic, bell, axis=0, mode="constant"), bell, axis=1, mode="wrap")
    return np.concatenate([cyclic, cyclic[:, :1]], axis=1)


def _solved(normal: Array, right: Array, count: Array, ridge: float, pairs: tuple[Any, Any]) -> Array:
    """Coefficients (angles, directions, 3, 6) that solve the normal equations of each bin."""
    matrix = np.zeros((*normal.shape[:2], TERMS, TERMS))
    matrix[..., pairs[0], pairs[1]] = normal
    matrix[..., pairs[1], pairs[0]] = normal
    # any pixel determines the constant term; its small ridge is for bins without a pixel
    ridges = np.array([1.0] * (TERMS - 1) + [1e-6])
    matrix += (ridge * count + 1e-9)[..., None, None] * np.diag(ridges)
    values = right.reshape(*right.shape[:2], 3, TERMS)
    return np.swapaxes(np.linalg.solve(matrix, np.swapaxes(values, -1, -2)), -1, -2)


def _filled(coefficients: Array, is_seen: NDArray[np.bool_]) -> Array:
    """Coefficients with those of each unseen bin replaced by the nearest seen bin's; directions are cyclic."""
    directions = is_seen.shape[1]
    if not is_seen.any():
        is_seen = np.ones_like(is_seen)
    # three copies side by side, of which the middle one has neighbours on both sides
    around = np.concatenate([is_seen[:, :-1]] * 3, axis=1)
    nearest = distance_transform_edt(~around, return_distances=False, return_indices=True)
    middle = slice(directions - 1, 2 * (directions - 1))
    angle, direction = nearest[0][:, middle], nearest[1][:, middle] % (directions - 1)
    filled = coefficients[angle, direction]
    return np.concatenate([filled, filled[:, :1]], axis=1)
