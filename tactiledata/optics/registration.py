"""Registration of one unit's camera: the point of the gel that each pixel sees, from touches of known meshes.

The places of gels and cameras in their housings differ by tenths of a millimetre, so that pictures drawn through the
nominal view are off by several pixels.
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
    improved_view,
    move_field,
    residual_of,
    shape_features,
)

LEAST_TOUCHES = {"shift": 2, "affine": 6, "projective": 8}
"""Fewest touches for each kind of registration."""
LEAST_SPREAD = 7e-4
"""Smallest standard deviation, m, of the places of contact in any direction; closer ones do not fix the scale."""
VISIBLE = 6.0
"""Smallest change of a picture by a touch, grey levels."""
WORK_ROWS = 80
"""Rows of the reduced pictures that are compared."""
COARSE, FINE = 1.5, 0.8
"""Blur, px, of the first search, in pictures of half the size to widen its range, and of the second search."""
MIRROR_MARGIN = 0.97
"""Largest ratio of residuals of the better view and its mirror image at which the better one is certain."""


@dataclass(frozen=True)
class Touch:
    """A picture of a touch whose mesh is known.

    Parameters
    ----------
    picture, background : (rows, columns, 3), uint8 RGB
        The touch, and the same unit without contact.
    displacement : (k, 3) m
        Displacement of the surface's nodes, gel frame.
    """

    picture: NDArray[np.uint8]
    background: NDArray[np.uint8]
    displacement: NDArray[np.floating]


@dataclass(frozen=True)
class Registration:
    """View of a registered camera, and how well it is known.

    Parameters
    ----------
    view : View
        The fitted view.
    error : px
        Root mean square, over the touches, of the shift that would fit each touch alone still better.
    moved : px
        Root mean square, over the picture, of the distance of the view from its start.
    unexplained : float
        Share of the pictures' squared change that the shapes do not explain, 0 to 1.
    touches : int
        Touches that took part.
    mirror_ratio : float
        Root of the residual of this view over that of the mirrored one; NaN where only one was tried.
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
    """Find the view in which the shapes of the meshes explain best how the touches change the pictures.

    A pixel's change of colour is modelled as a quadratic of the gel's slope there, plus its depth and curvature, with
    coefficients that vary linearly over the picture. They are fitted anew for every view that is tried, so that no
    calibration of the colours is needed. The view is improved by damped Gauss-Newton steps.

    Parameters
    ----------
    surface : GelSurface
        Undeformed surface of the unit's gel.
    touches : sequence of Touch
        Touches of one unit; those that are not visible in picture and mesh take no part.
    start : View
        Within some 15 px (of 320 rows) of the truth.
    kind : "shift", "affine" or "projective"
        Freedom of the view.
    try_mirror : bool
        Try the mirror image of ``start`` as well and take the better one.

    Raises
    ------
    TactileDataError
        There are too few touches, they lie in one place, or the mirror image fits as well.
    UsageError
        Pictures of several shapes, or an unknown kind.
    """
    if kind not in PARAMETERS:
        raise UsageError(f"a registration of kind {kind!r}", f"one of {', '.join(PARAMETERS)}", "")
    scene = _scene(surface, touches, start, kind)
    # coarse search from the start and from its mirror image
    candidates = [_coarse_view(scene, view, kind) for view in ([start, _mirrored(start)] if try_mirror else [start])]
    (smallest, view), *others = sorted(candidates, key=lambda candidate: candidate[0])
    ratio = float(np.sqrt(smallest / max(others[0][0], 1e-12))) if others else float("nan")
    if ratio > MIRROR_MARGIN:
        raise TactileDataError(
            f"the view and its mirror image explain the pictures equally well (ratio {ratio:.2f})",
            "touches away from the middle, or of shapes without symmetry",
            "Add touches, or state the right one as the start with try_mirror=False.",
            ratio=ratio,
        )
    return _registration(scene, start if view.is_mirrored == start.is_mirrored else _mirrored(start), view, kind, ratio)


def _scene(surface: GelSurface, touches: Sequence[Touch], start: View, kind: Kind) -> Scene:
    """Prepare reduced pictures and shapes of the visible touches; refuse too few or too close ones."""
    shapes = {touch.picture.shape for touch in touches} | {touch.background.shape for touch in touches}
    if len(shapes) > 1:
        raise UsageError(f"pictures of shapes {sorted(shapes)}", "one shape", "")
    grid = _gel_grid(surface)
    indentation = Indentation(surface, grid)
    shape = (WORK_ROWS, round(WORK_ROWS * start.shape[1] / start.shape[0]))
    changes, features, places = [], [], []
    for touch in touches:
        change = _reduced(touch.picture, shape) - _reduced(touch.background, shape)
        change -= np.median(change, axis=(0, 1))  # lights that warm up change all pixels equally
        depth = indentation.of(touch.displacement)
        excess_depth = np.clip(depth - CONTACT_DEPTH, 0.0, None)
        if excess_depth.max() <= CONTACT_DEPTH or _strength(change) < VISIBLE:
            continue
        changes.append(change)
        features.append(shape_features(depth, grid))
        places.append((grid.points() * excess_depth[..., None]).sum(axis=(0, 1)) / excess_depth.sum())
    _need_enough(np.array(places).reshape(-1, 2), len(touches), kind)
    return Scene(changes, features, grid, shape, start.scaled(shape).pitches)


def _reduced(picture: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.float32]:
    """Picture reduced to another shape by averaging over areas."""
    reduced: Any = cv2.resize(picture.astype(np.float32), shape[::-1], interpolation=cv2.INTER_AREA)
    return reduced


def _strength(change: NDArray[np.float32]) -> float:
    """Strongest change of a picture, grey levels, robust against single pixels."""
    return float(np.quantile(np.abs(cv2.GaussianBlur(change, (0, 0), 1.0)).max(axis=2), 0.995))


def _need_enough(places: Array, offered: int, kind: Kind) -> None:
    """Refuse places of contact (n, 2), m, that are too few, or on a spot or a line; ``offered`` is for the message."""
    if len(places) < LEAST_TOUCHES[kind]:
        raise TactileDataError(
            f"{len(places)} of {offered} touches are visible in picture and mesh",
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
    """View of the whole pad with square pixels of ``GEL_PITCH``, columns along gel x and rows along gel y."""
    low, high = surface.places[:, :2].min(axis=0), surface.places[:, :2].max(axis=0)
    columns, rows = np.ceil((high - low) / GEL_PITCH).astype(int) + 1
    return View(
        (int(rows), int(columns)), np.array([[GEL_PITCH, 0, low[0]], [0, GEL_PITCH, low[1]], [0, 0, 1]], np.float64)
    )


def _coarse_view(scene: Scene, start: View, kind: Kind) -> tuple[float, View]:
    """Squared residual and view after a search in half-size, blurred pictures."""
    coarse = scene.halved().blurred(COARSE)
    view = improved_view(coarse, start.scaled(coarse.shape), kind)
    residual, _ = residual_of(coarse, view)
    return float(residual @ residual), view


def _registration(scene: Scene, start: View, coarse: View, kind: Kind, ratio: float) -> Registration:
    """Refine a coarse view in the less blurred pictures, and return it with its errors."""
    fine = scene.blurred(FINE)
    view = improved_view(fine, coarse.scaled(fine.shape), kind)
    residual, predicted = residual_of(fine, view)
    total = sum(float(np.square(change, dtype=np.float64).sum()) for change in fine.changes)
    scale = start.shape[0] / scene.shape[0]
    return Registration(
        view.scaled(start.shape),
        scale * _leftover_shift(fine, predicted),
        scale * float(np.sqrt(np.square(move_field(start.scaled(scene.shape), view)).sum(axis=-1).mean())),
        float(residual @ residual) / max(total, 1e-12),
        len(scene.changes),
        ratio,
    )


def _mirrored(view: View) -> View:
    """View with its columns reversed."""
    flip = np.array([[-1.0, 0, view.shape[1] - 1], [0, 1, 0], [0, 0, 1]])
    return View(view.shape, view.gel_from_pixel @ flip)


def _leftover_shift(scene: Scene, predicted: NDArray[np.float32]) -> float:
    """Root mean square, px of the reduced picture, of the shift that fits each touch alone best."""
    window: Any = cv2.createHanningWindow(scene.shape[::-1], cv2.CV_32F)
    squares = []
    for change, expected in zip(scene.changes, predicted, strict=True):
        shifts = [cv2.phaseCorrelate(expected[..., k].copy(), change[..., k].copy(), window)[0] for k in range(3)]
        squares.append(np.square(np.median(shifts, axis=0)).sum())
    return float(np.sqrt(np.mean(squares)))
