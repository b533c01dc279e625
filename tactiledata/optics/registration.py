"""Registration of one unit's camera: which point of the gel each pixel sees, from touches of known meshes.

Gels sit in their housings by tenths of a millimetre differently, and cameras behind them: pictures drawn through
the nominal view lie beside the real ones by several pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.optics.height_map import CONTACT_DEPTH, Indentation
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.optics.view_search import (
    GEL_PITCH,
    PARAMETERS,
    Kind,
    Scene,
    improved,
    move_field,
    residual_of,
    shape_features,
)

LEAST_TOUCHES = {"shift": 2, "affine": 6, "projective": 8}
LEAST_SPREAD = 7e-4
"""m, standard deviation of the places of contact along the direction in which they spread least: closer together they
tell where the camera looks, but not its scale."""
VISIBLE = 6.0
"""Grey levels by which a touch must change its picture."""
WORK_ROWS = 80
"""Rows of the reduced pictures that are compared."""
COARSE, FINE = 1.5, 0.8
"""px by which everything is blurred: first of pictures reduced to half once more, to be drawn in from afar."""
MIRROR_MARGIN = 0.97
"""Ratio of the residuals of the right view and its mirror image above which the two cannot be told apart."""


@dataclass(frozen=True)
class Touch:
    """A picture of a touch whose mesh is known.

    Parameters
    ----------
    picture, background : (rows, columns, 3), uint8 RGB
    displacement : (k, 3), metres
    """

    picture: NDArray[np.uint8]
    background: NDArray[np.uint8]
    displacement: NDArray[np.floating]


@dataclass(frozen=True)
class Registration:
    """A registered camera.

    Parameters
    ----------
    view : View
    error : px
        Root mean square, over the touches, of the shift that would fit each touch alone still better.
    moved : px
        Root mean square, over the picture, of how far the view has moved from where it started.
    unexplained : float
        Share of the pictures' change that the shapes do not explain, 0 to 1.
    touches : int
    mirror_ratio : float
        ``unexplained`` over that of the mirrored view; NaN where only one was tried.
    """

    view: View
    error: float
    moved: float
    unexplained: float
    touches: int
    mirror_ratio: float = float("nan")


def register(
    surface: GelSurface,
    touches: Sequence[Touch],
    start: View,
    kind: Kind = "affine",
    try_mirror: bool = True,
) -> Registration:
    """The view in which the shapes of the meshes explain best what the touches change in the pictures.

    A pixel's change of colour is taken as a quadratic of the gel's slope there, plus its depth and curvature, with
    coefficients that vary linearly over the picture. They are fitted anew for every view that is tried, so that no
    calibration of the colours is needed. The view is improved by damped Gauss-Newton steps.

    Parameters
    ----------
    surface : GelSurface
    touches : sequence of Touch
        Of one unit; those that do not show in the picture or the mesh take no part.
    start : View
        Within some 15 px (of 320 rows) of the truth.
    kind : "shift", "affine" or "projective"
    try_mirror : bool
        Try the mirror image of ``start`` as well and take the better one.

    Raises
    ------
    TactileDataError
        Too few touches, or all in one place, or a mirror image that fits as well.
    UsageError
        Pictures of several shapes.
    """
    if kind not in PARAMETERS:
        raise UsageError(f"a registration of kind {kind!r}", f"one of {', '.join(PARAMETERS)}", "")
    scene = _scene(surface, touches, start, kind)
    drawn_in = [_drawn_in(scene, view, kind) for view in ([start, _mirrored(start)] if try_mirror else [start])]
    (least, view), *others = sorted(drawn_in, key=lambda found: found[0])
    ratio = float(np.sqrt(least / max(others[0][0], 1e-12))) if others else float("nan")
    if ratio > MIRROR_MARGIN:
        raise TactileDataError(
            f"the view and its mirror image explain the pictures alike (ratio {ratio:.2f})",
            "touches away from the middle, or of shapes without symmetry",
            "Add touches, or say which it is with try_mirror=False.",
            ratio=ratio,
        )
    return _judged(scene, start if view.is_mirrored == start.is_mirrored else _mirrored(start), view, kind, ratio)


def _scene(surface: GelSurface, touches: Sequence[Touch], start: View, kind: Kind) -> Scene:
    shapes = {touch.picture.shape for touch in touches} | {touch.background.shape for touch in touches}
    if len(shapes) > 1:
        raise UsageError(f"pictures of shapes {sorted(shapes)}", "one shape", "")
    grid = _gel_grid(surface)
    drawn = Indentation(surface, grid)
    shape = (WORK_ROWS, round(WORK_ROWS * start.shape[1] / start.shape[0]))
    changes, shown, places = [], [], []
    for touch in touches:
        change = _reduced(touch.picture, shape) - _reduced(touch.background, shape)
        change -= np.median(change, axis=(0, 1))  # lights that warm up change everything alike
        depth = drawn.of(touch.displacement)
        pressed = np.clip(depth - CONTACT_DEPTH, 0.0, None)
        if pressed.max() <= CONTACT_DEPTH or _strength(change) < VISIBLE:
            continue
        changes.append(change)
        shown.append(shape_features(depth, grid))
        places.append((grid.points() * pressed[..., None]).sum(axis=(0, 1)) / pressed.sum())
    _enough(np.array(places).reshape(-1, 2), len(touches), kind)
    return Scene(changes, shown, grid, shape, start.scaled(shape).pitches)


def _reduced(picture: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.float32]:
    small: Any = cv2.resize(picture.astype(np.float32), shape[::-1], interpolation=cv2.INTER_AREA)
    return small


def _strength(change: NDArray[np.float32]) -> float:
    return float(np.quantile(np.abs(cv2.GaussianBlur(change, (0, 0), 1.0)).max(axis=2), 0.995))


def _enough(places: Array, offered: int, kind: Kind) -> None:
    if len(places) < LEAST_TOUCHES[kind]:
        raise TactileDataError(
            f"{len(places)} of {offered} touches show in picture and mesh",
            f"at least {LEAST_TOUCHES[kind]} for a registration of kind {kind!r}",
            "Add touches with more depth, or register a shift only.",
            touches=len(places),
        )
    if kind == "shift":
        return
    spread = float(np.sqrt(max(np.linalg.eigvalsh(np.cov(places.T))[0], 0.0)))
    if spread < LEAST_SPREAD:
        raise TactileDataError(
            f"the touches lie on a spot or a line: they spread by {spread * 1e3:.2f} mm across it",
            f"at least {LEAST_SPREAD * 1e3:.1f} mm in every direction",
            "Add touches elsewhere on the gel, or register a shift only.",
            spread=spread,
        )


def _gel_grid(surface: GelSurface) -> View:
    """A view of the whole pad, straight on, columns along gel x."""
    low, high = surface.places[:, :2].min(axis=0), surface.places[:, :2].max(axis=0)
    columns, rows = np.ceil((high - low) / GEL_PITCH).astype(int) + 1
    return View(
        (int(rows), int(columns)), np.array([[GEL_PITCH, 0, low[0]], [0, GEL_PITCH, low[1]], [0, 0, 1]], np.float64)
    )


def _drawn_in(scene: Scene, start: View, kind: Kind) -> tuple[float, View]:
    """The view from a coarse look, and the squared residual that it leaves."""
    coarse = scene.halved().blurred(COARSE)
    view = improved(coarse, start.scaled(coarse.shape), kind)
    residual, _ = residual_of(coarse, view)
    return float(residual @ residual), view


def _judged(scene: Scene, start: View, coarse: View, kind: Kind, ratio: float) -> Registration:
    """The view refined, with its errors."""
    fine = scene.blurred(FINE)
    view = improved(fine, coarse.scaled(fine.shape), kind)
    residual, predicted = residual_of(fine, view)
    whole = sum(float(np.square(change, dtype=np.float64).sum()) for change in fine.changes)
    scale = start.shape[0] / scene.shape[0]
    return Registration(
        view.scaled(start.shape),
        scale * _leftover_shift(fine, predicted),
        scale * float(np.sqrt(np.square(move_field(start.scaled(scene.shape), view)).sum(axis=-1).mean())),
        float(residual @ residual) / max(whole, 1e-12),
        len(scene.changes),
        ratio,
    )


def _mirrored(view: View) -> View:
    flip = np.array([[-1.0, 0, view.shape[1] - 1], [0, 1, 0], [0, 0, 1]])
    return View(view.shape, view.gel_from_pixel @ flip)


def _leftover_shift(scene: Scene, predicted: NDArray[np.float32]) -> float:
    """Root mean square, px of the reduced picture, of the best shift of each touch alone."""
    window: Any = cv2.createHanningWindow(scene.shape[::-1], cv2.CV_32F)
    squares = []
    for change, ours in zip(scene.changes, predicted, strict=True):
        shifts = [cv2.phaseCorrelate(ours[..., k].copy(), change[..., k].copy(), window)[0] for k in range(3)]
        squares.append(np.square(np.median(shifts, axis=0)).sum())
    return float(np.sqrt(np.mean(squares)))
