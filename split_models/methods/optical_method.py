"""Pictures of deformed meshes without latent spaces: height map, slopes, a colour model, shadows, background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from split_models.recipe.recipe_run import RecipeRun
from tactiledata.errors import UsageError
from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.registration import Touch
from tactiledata.optics.shadows import Shadows, fit_shadows, light_azimuths
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.taxim_calibration import CalibrationPress, calibrate
from tactiledata.optics.view import View

Colours = Callable[[NDArray[np.float32]], NDArray[np.float32]]
"""A function of slopes (rows, columns, 2) that gives the change of colour (rows, columns, 3), grey levels."""

SMOOTHING = 2e-4
"""Standard deviation in m of the blur that removes the facets of the mesh from a height map."""


@dataclass(frozen=True)
class OpticalMethod:
    """Taxim or FOTS: they differ in their colours and in the surface that shadows fall on.

    Parameters
    ----------
    name : str
        Name of the row in tables.
    surface : GelSurface
        The mesh that displacements belong to.
    view : View
        The camera's view of the gel; it is scaled for backgrounds of another size.
    colours : callable
        Change of colour from slopes.
    shadows : Shadows, optional
        Shadows that darken the background; none unless given.
    """

    name: str
    surface: GelSurface
    view: View
    colours: Colours
    shadows: Shadows | None = None

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pictures (n, rows, columns, 3) uint8 of displacements (n, k, 3), m, on a background (rows, columns, 3)."""
        steps = self.steps(background)
        pictures = np.empty((len(displacements), *background.shape), np.uint8)
        for row, displacement in enumerate(displacements):
            result: Any = displacement[None]
            for _, step in steps:
                result = step(result)
            pictures[row] = result[0]
        return pictures

    def steps(self, background: NDArray[np.uint8]) -> list[tuple[str, Callable[[Any], Any]]]:
        """The steps of `predict` for one displacement (1, k, 3) as named functions; the gel at rest is drawn once."""
        view = self.view.scaled((background.shape[0], background.shape[1]))
        drawn, base = Indentation(self.surface, view), background.astype(np.float32)

        def picture(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
            shown = base + self.colours(slopes(depth, view))
            if self.shadows is not None:
                shown -= base * self.shadows.darkening(depth, view)
            return np.clip(np.rint(shown), 0, 255).astype(np.uint8)[None]

        return [("height map", lambda moved: smooth_indentation(drawn, moved[0])), ("optics", picture)]


def surface_of(recipe_run: RecipeRun) -> GelSurface:
    """The undeformed gel surface of the mesh of a recipe's store."""
    frames = recipe_run.frames("train")
    return GelSurface.of_pad(frames.arrays.store.mesh(frames.mesh_name).pad())


def calibrated(
    name: str,
    surface: GelSurface,
    view: View,
    touches: Sequence[Touch],
    learn: Callable[[list[CalibrationPress]], Colours],
    is_planar: bool,
) -> OpticalMethod:
    """A method calibrated on touches of one unit with known meshes, seen through its registered camera.

    Parameters
    ----------
    name, surface, view
        As for `OpticalMethod`.
    touches : sequence of Touch
        Pictures with backgrounds and displacements.
    learn : callable
        Function of presses that gives colours.
    is_planar : bool
        Whether shadows fall on the flat gel.

    Raises
    ------
    UsageError
        There is no touch, or none that shows a contact.
    """
    if not touches:
        raise UsageError(f"no touch to calibrate {name} on", "pictures with their meshes", "")
    # colours from the slopes that the touches' meshes have
    rows, columns = touches[0].picture.shape[:2]
    here = view.scaled((rows, columns))
    drawn = Indentation(surface, here)
    depths = [smooth_indentation(drawn, touch.displacement) for touch in touches]
    presses = [_press(touch, depth, here) for touch, depth in zip(touches, depths, strict=True)]
    colours = learn(presses)
    # shadows from what the colours do not explain
    residuals = [press.change - colours(press.slopes) for press in presses]
    azimuths = light_azimuths(calibrate(presses, "for the directions of the lights"))
    shadows = fit_shadows(residuals, [touch.background for touch in touches], depths, here, azimuths, is_planar)
    return OpticalMethod(name, surface, view, colours, shadows)


def _press(touch: Touch, depth: NDArray[np.float32], view: View) -> CalibrationPress:
    """A touch as a calibration press whose slopes are known at every pixel."""
    change = touch.picture.astype(np.float32) - touch.background
    return CalibrationPress(change, slopes(depth, view), np.ones(depth.shape, bool))


def smooth_indentation(drawn: Indentation, displacement: Any) -> NDArray[np.float32]:
    """Indentation (rows, columns), metres, of a mesh with displacements (k, 3), m, blurred to remove its facets."""
    across, down = drawn.view.pitches
    blurred: Any = cv2.GaussianBlur(drawn.of(displacement), (0, 0), sigmaX=SMOOTHING / across, sigmaY=SMOOTHING / down)
    return blurred
