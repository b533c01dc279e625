"""Taxim, FOTS and ACROSS as rows of the tables: with published calibrations, and calibrated for each unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.methods import fots
from split_models.methods import taxim as taxim_method
from split_models.methods.across import AcrossMethod
from split_models.methods.optical_method import OpticalMethod
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.errors import UsageError
from tactiledata.optics.registration import Touch, register
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

LEAST_TOUCHES = 8
"""Of a unit in a part of the split; with fewer, another part is looked at."""
MOST_TOUCHES = 40

Calibrate = Callable[[GelSurface, View, Sequence[Touch]], OpticalMethod]


@dataclass
class PerUnit:
    """A method that is registered and calibrated for each unit on touches of that unit.

    A unit that is in no other part is calibrated on touches of the part that it is tested on: that favours this method,
    and is what its authors ask for.

    Parameters
    ----------
    name : str
    recipe_run : RecipeRun
    calibrate : callable
        Surface, view and touches -> method.
    """

    name: str
    recipe_run: RecipeRun
    calibrate: Calibrate
    _units: dict[str, OpticalMethod] = field(default_factory=dict)

    def for_sensor(self, sensor: str) -> OpticalMethod:
        """The method of a unit.

        Raises
        ------
        TactileDataError
            Its touches do not show where the camera is.
        """
        if sensor not in self._units:
            surface, touches = surface_of(self.recipe_run), unit_touches(self.recipe_run, sensor)
            start = View.nominal(DIGIT, touches[0].picture.shape[:2])
            view = register(surface, touches, start).view
            self._units[sensor] = self.calibrate(surface, view, touches)
        return self._units[sensor]

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Refused: which unit it is must be said."""
        raise UsageError(f"{self.name} without a unit", "`for_sensor(sensor).predict(…)`", "It is calibrated by unit.")


def surface_of(recipe_run: RecipeRun) -> GelSurface:
    """The surface of the store's mesh."""
    frames = recipe_run.frames("train")
    return GelSurface.of_pad(frames.arrays.store.mesh(frames.mesh_name).pad())


def unit_touches(recipe_run: RecipeRun, sensor: str) -> list[Touch]:
    """A frame of each of a unit's trajectories, the one that is deformed most; of train where the unit is there.

    Raises
    ------
    UsageError
        No part of the split has frames of the unit.
    """
    best: list[Touch] = []
    for part in dict.fromkeys(["train", *recipe_run.recipe.rows["parts"]]):
        frames = recipe_run.frames(part)
        mine = np.flatnonzero(frames.sensors == sensor)
        names = list(dict.fromkeys(frames.trajectories[mine]))[:MOST_TOUCHES]
        found = []
        for name in names:
            numbers = mine[frames.trajectories[mine] == name]
            moved = frames.displacements(numbers)
            deepest = int(np.linalg.norm(moved, axis=2).max(axis=1).argmax())
            picture = frames.pictures(numbers[deepest : deepest + 1])[0]
            found.append(Touch(picture, frames.background(sensor), moved[deepest]))
        if len(found) > len(best):
            best = found
        if len(best) >= LEAST_TOUCHES:
            break
    if not best:
        raise UsageError(f"no frame of sensor {sensor!r} in any part of the table", "touches to calibrate on", "")
    return best


def taxim_published(recipe_run: RecipeRun) -> OpticalMethod:
    """Taxim with the published DIGIT table and the nominal camera."""
    return taxim_method.taxim_published(surface_of(recipe_run))


def taxim_calibrated(recipe_run: RecipeRun) -> PerUnit:
    """Taxim registered and calibrated for each unit."""
    return PerUnit("taxim_calibrated", recipe_run, taxim_method.taxim_calibrated)


def fots_published(recipe_run: RecipeRun) -> OpticalMethod:
    """FOTS' network taught by the published DIGIT table, and the nominal camera."""
    return fots.fots_published(surface_of(recipe_run))


def fots_calibrated(recipe_run: RecipeRun) -> PerUnit:
    """FOTS registered and calibrated for each unit."""
    return PerUnit("fots_calibrated", recipe_run, fots.fots_calibrated)


def across(recipe_run: RecipeRun) -> AcrossMethod:
    """ACROSS: the mesh VAE, and Taxim with the published table."""
    return AcrossMethod(recipe_run.mesh_vae, taxim_published(recipe_run))
