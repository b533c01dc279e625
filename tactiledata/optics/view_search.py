"""Search for the view in which the shapes of meshes explain how touches change pictures."""

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
"""Number of parameters of each kind of registration."""
GEL_PITCH = 1e-4
"""Distance, m, between the points at which the shape of the gel is sampled."""
CURVED = 3e-4
"""Standard deviation, m, of the blur before the curvature is computed."""
ROUNDS = 15
"""Most Gauss-Newton rounds."""
GIVEN_UP = 1e3
"""Damping at which the search ends because no step improves the view."""
STEP = 0.3
"""Step of finite differences, px of the reduced picture."""
CONVERGED = 2e-2
"""Largest change of a parameter, px of the reduced picture, at which the search ends."""


@dataclass(frozen=True)
class Scene:
    """Reduced pictures and shapes of n touches, which stay the same while views are tried.

    Parameters
    ----------
    changes : n of (rows, columns, 3)
        Changes of the reduced pictures, grey levels.
    features : n of (grid rows, grid columns, 4)
        Shapes of the gel, as ``shape_features`` returns them.
    grid : View
        View of the shapes' grid.
    shape : (rows, columns)
        Size of the reduced pictures.
    pitches : (across, down) m
        Distances on the gel between neighbouring pixels of the reduced pictures.
    """

    changes: list[NDArray[np.float32]]
    features: list[NDArray[np.float32]]
    grid: View
    shape: tuple[int, int]
    pitches: tuple[float, float]

    def halved(self) -> Scene:
        """Return the scene with pictures of half the rows and columns."""
        shape = (self.shape[0] // 2, self.shape[1] // 2)
        halves: list[Any] = [cv2.resize(change, shape[::-1], interpolation=cv2.INTER_AREA) for change in self.changes]
        return replace(self, changes=halves, shape=shape, pitches=(2 * self.pitches[0], 2 * self.pitches[1]))

    def blurred(self, width: float) -> Scene:
        """Return the scene with pictures and shapes blurred by ``width`` px (standard deviation) of its pictures."""
        across, down = (width * pitch / GEL_PITCH for pitch in self.pitches)
        return replace(
            self,
            changes=[_blurred(change, width, width) for change in self.changes],
            features=[_blurred(shape, across, down) for shape in self.features],
        )


def shape_features(depth: NDArray[np.float32], grid: View) -> NDArray[np.float32]:
    """Features (rows, columns, 4) of an indentation, m: slopes along x and y, depth in mm, curvature per mm.

    Curvature represents light that folds lose; without it shadows shift the view by pixels.
    """
    smooth = _blurred(depth, CURVED / GEL_PITCH, CURVED / GEL_PITCH)
    curvature: Any = cv2.Laplacian(smooth, cv2.CV_32F) / np.float32(GEL_PITCH**2 * 1e3)
    return np.dstack([slopes(depth, grid), depth * np.float32(1e3), curvature])


def _blurred(values: NDArray[np.float32], across: float, down: float) -> NDArray[np.float32]:
    """Values (rows, columns, ...) blurred by standard deviations across and down, px."""
    blurred: Any = cv2.GaussianBlur(values, (0, 0), sigmaX=across, sigmaY=down)
    return blurred


def improved_view(scene: Scene, start: View, kind: Kind) -> View:
    """Improve a view by damped Gauss-Newton steps; a step that does not lower the residual raises the damping.

    Parameters
    ----------
    scene : Scene
        Pictures and shapes.
    start : View
        View of the scene's pictures from which the search starts.
    kind : "shift", "affine" or "projective"
        Freedom of the view.
    """
    moves = np.zeros(PARAMETERS[kind])
    residual, _ = residual_of(scene, start)
    damping = 1e-3
    for _ in range(ROUNDS):
        current = moves
        jacobian = np.stack(
            [
                (residual_of(scene, moved_view(start, current + STEP * axis))[0] - residual) / STEP
                for axis in np.eye(len(current))
            ],
            axis=1,
        )
        normal, right = jacobian.T @ jacobian, -jacobian.T @ residual
        # raise the damping until a step lowers the residual
        while moves is current and damping < GIVEN_UP:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), right)
            trial, _ = residual_of(scene, moved_view(start, current + step))
            if trial @ trial < residual @ residual:
                moves, residual, damping = current + step, trial, damping / 5
            else:
                damping *= 5
        if moves is current or np.abs(moves - current).max() < CONVERGED:
            break
    return moved_view(start, moves)


def moved_view(view: View, moves: Array) -> View:
    """Return a view whose pixels were moved by parameters (2,), (6,) or (8,): shift, linear and perspective part.

    Each parameter is the motion in px that it causes at the picture's edges.
    """
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
    """Motion (rows, columns, 2), px, of the gel point that each pixel shows, from one view to another."""
    columns, rows = np.meshgrid(np.arange(before.shape[1]), np.arange(before.shape[0]))
    return before.pixels_at(after.points()) - np.stack([columns, rows], axis=-1)


def residual_of(scene: Scene, view: View) -> tuple[Array, NDArray[np.float32]]:
    """Return the changes that shapes do not explain through a view (flat), and those that they do.

    The explained part is (n, rows, columns, 3), in grey levels; the residual is the rest of the changes, flattened.
    """
    grid_from_pixel = np.linalg.inv(scene.grid.gel_from_pixel) @ view.gel_from_pixel
    v, u = np.meshgrid(*(np.linspace(-1, 1, size) for size in scene.shape), indexing="ij")
    places = np.stack([np.ones_like(u), u, v], axis=-1).astype(np.float32)
    columns = []
    for shape in scene.features:
        warped: Any = cv2.warpPerspective(
            shape, grid_from_pixel, scene.shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        x, y = warped[..., 0], warped[..., 1]
        powers = np.dstack([warped, x * x, y * y, x * y])
        columns.append((powers[..., :, None] * places[..., None, :]).reshape(len(x) * x.shape[1], -1))
    features, target = np.concatenate(columns), np.concatenate([change.reshape(-1, 3) for change in scene.changes])
    normal = (features.T @ features).astype(np.float64)
    normal += 1e-6 * np.trace(normal) / len(normal) * np.eye(len(normal))
    predicted = features @ np.linalg.solve(normal, features.T @ target).astype(np.float32)
    residual = (target - predicted).astype(np.float64).ravel()
    return residual, predicted.reshape(-1, *scene.shape, 3)
