"""The search for the view in which the shapes of meshes explain what touches change in pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.optics.height_map import slopes
from tactiledata.optics.view import View

Kind = Literal["shift", "affine", "projective"]

PARAMETERS = {"shift": 2, "affine": 6, "projective": 8}
GEL_PITCH = 1e-4
"""m between the points on which the shape of the gel is kept."""
CURVED = 3e-4
"""m: standard deviation of the blur before the curvature is taken."""
ROUNDS = 15
GIVEN_UP = 1e3
"""Damping at which no step helps any more."""
STEP = 0.3
"""px of the reduced picture, for differences."""
CONVERGED = 2e-2
"""px of the reduced picture."""


@dataclass(frozen=True)
class Scene:
    """What does not change while views are tried.

    Parameters
    ----------
    changes : n of (rows, columns, 3)
        Of the reduced pictures, grey levels.
    shown : n of (grid rows, grid columns, 4)
        Shapes of the gel, as ``shape_features`` has them.
    grid : View
        Of the shapes.
    shape : (rows, columns)
        Of the reduced pictures.
    pitches : (across, down)
        Metres on the gel from pixel to pixel of the reduced pictures.
    """

    changes: list[NDArray[np.float32]]
    shown: list[NDArray[np.float32]]
    grid: View
    shape: tuple[int, int]
    pitches: tuple[float, float]

    def halved(self) -> Scene:
        """The same with half the rows and columns."""
        shape = (self.shape[0] // 2, self.shape[1] // 2)
        small: list[Any] = [cv2.resize(change, shape[::-1], interpolation=cv2.INTER_AREA) for change in self.changes]
        return replace(self, changes=small, shape=shape, pitches=(2 * self.pitches[0], 2 * self.pitches[1]))

    def blurred(self, width: float) -> Scene:
        """The same, blurred by ``width`` px of the reduced picture."""
        across, down = (width * pitch / GEL_PITCH for pitch in self.pitches)
        return replace(
            self,
            changes=[_blurred(change, width, width) for change in self.changes],
            shown=[_blurred(features, across, down) for features in self.shown],
        )


def shape_features(depth: NDArray[np.float32], grid: View) -> NDArray[np.float32]:
    """What a picture may show of an indentation (rows, columns, 4): slopes along x and y, depth in mm, curvature.

    Curvature stands for light that folds lose: without it shadows pull the view to one side by pixels.
    """
    smooth = _blurred(depth, CURVED / GEL_PITCH, CURVED / GEL_PITCH)
    curvature: Any = cv2.Laplacian(smooth, cv2.CV_32F) / np.float32(GEL_PITCH**2 * 1e3)
    return np.dstack([slopes(depth, grid), depth * np.float32(1e3), curvature])


def _blurred(values: NDArray[np.float32], across: float, down: float) -> NDArray[np.float32]:
    blurred: Any = cv2.GaussianBlur(values, (0, 0), sigmaX=across, sigmaY=down)
    return blurred


def improved(scene: Scene, start: View, kind: Kind) -> View:
    """Levenberg's steps: each that makes the residual smaller is taken, each other damps the next."""
    moves = np.zeros(PARAMETERS[kind])
    residual, _ = residual_of(scene, start)
    damping = 1e-3
    for _ in range(ROUNDS):
        here = moves
        jacobian = np.stack(
            [
                (residual_of(scene, moved_view(start, here + STEP * axis))[0] - residual) / STEP
                for axis in np.eye(len(here))
            ],
            axis=1,
        )
        normal, right = jacobian.T @ jacobian, -jacobian.T @ residual
        while moves is here and damping < GIVEN_UP:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), right)
            tried, _ = residual_of(scene, moved_view(start, here + step))
            if tried @ tried < residual @ residual:
                moves, residual, damping = here + step, tried, damping / 5
            else:
                damping *= 5
        if moves is here or np.abs(moves - here).max() < CONVERGED:
            break
    return moved_view(start, moves)


def moved_view(view: View, moves: Array) -> View:
    """The view after a change of its pixels, in px at the edges: shift, then linear, then perspective parts."""
    half = np.array([view.shape[1], view.shape[0]]) / 2
    change = np.eye(3)
    change[:2, 2] = moves[:2]
    if len(moves) > 2:
        change[:2, :2] += moves[2:6].reshape(2, 2) / half
    if len(moves) > 6:
        change[2, :2] = moves[6:8] / half / half.mean()
    centred = np.array([[1, 0, -half[0] + 0.5], [0, 1, -half[1] + 0.5], [0, 0, 1]])
    return View(view.shape, view.gel_from_pixel @ np.linalg.inv(centred) @ change @ centred)


def move_field(before: View, after: View) -> Array:
    """How far (rows, columns, 2), px, what each pixel shows has moved."""
    columns, rows = np.meshgrid(np.arange(before.shape[1]), np.arange(before.shape[0]))
    return before.pixels_at(after.points()) - np.stack([columns, rows], axis=-1)


def residual_of(scene: Scene, view: View) -> tuple[Array, NDArray[np.float32]]:
    """What slopes seen through a view leave of the changes (flat), and what they explain (n, rows, columns, 3)."""
    grid_from_pixel = np.linalg.inv(scene.grid.gel_from_pixel) @ view.gel_from_pixel
    v, u = np.meshgrid(*(np.linspace(-1, 1, size) for size in scene.shape), indexing="ij")
    places = np.stack([np.ones_like(u), u, v], axis=-1).astype(np.float32)
    seen = []
    for shown in scene.shown:
        warped: Any = cv2.warpPerspective(
            shown, grid_from_pixel, scene.shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        x, y = warped[..., 0], warped[..., 1]
        powers = np.dstack([warped, x * x, y * y, x * y])
        seen.append((powers[..., :, None] * places[..., None, :]).reshape(len(x) * x.shape[1], -1))
    features, target = np.concatenate(seen), np.concatenate([change.reshape(-1, 3) for change in scene.changes])
    normal = (features.T @ features).astype(np.float64)
    normal += 1e-6 * np.trace(normal) / len(normal) * np.eye(len(normal))
    predicted = features @ np.linalg.solve(normal, features.T @ target).astype(np.float32)
    residual = (target - predicted).astype(np.float64).ravel()
    return residual, predicted.reshape(-1, *scene.shape, 3)
