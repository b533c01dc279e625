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
from split_models.methods.optical_method import OpticalMethod, surface_of
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.errors import UsageError
from tactiledata.optics.registration import Touch, register
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

LEAST_TOUCHES = 8
"""Touches of a unit in a part of the split that suffice; with fewer, further parts are searched."""
MOST_TOUCHES = 40
"""Largest number of touches that a unit is calibrated on."""

Calibrate = Callable[[GelSurface, View, Sequence[Touch]], OpticalMethod]
"""A function of surface, view and touches that gives a calibrated method."""


@dataclass(frozen=True)
class PerUnit:
    """A method that is registered and calibrated for each unit (single sensor) on touches of that unit.

    A unit that is in no other part is calibrated on touches of the part that it is tested on. That favours the method,
    and is what its authors prescribe.

    Parameters
    ----------
    name : str
        Name of the row in tables.
    recipe_run : RecipeRun
        The run whose frames are calibrated on.
    calibrate : callable
        Function of surface, view and touches that gives a method.
    """

    name: str
    recipe_run: RecipeRun
    calibrate: Calibrate
    _units: dict[str, OpticalMethod] = field(default_factory=dict)

    def for_sensor(self, sensor: str) -> OpticalMethod:
        """The method calibrated for a unit; each unit is calibrated once.

        Raises
        ------
        TactileDataError
            The camera cannot be registered on the unit's touches.
        """
        if sensor not in self._units:
            surface, touches = surface_of(self.recipe_run), unit_touches(self.recipe_run, sensor)
            start = View.nominal(DIGIT, touches[0].picture.shape[:2])
            view = register(surface, touches, start).view
            self._units[sensor] = self.calibrate(surface, view, touches)
        return self._units[sensor]

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Refuse to predict for an unknown unit: the method must first be chosen by `for_sensor`."""
        raise UsageError(f"{self.name} without a unit", "`for_sensor(sensor).predict(…)`", "Calibration is by unit.")


def unit_touches(recipe_run: RecipeRun, sensor: str) -> list[Touch]:
    """Touches of a unit to calibrate on: of each of its trajectories the frame with the largest displacement.

    The train part is searched first, then the parts of the table; the search ends at `LEAST_TOUCHES` touches, else the
    part with the most touches is taken.

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
        touches = []
        for name in names:
            numbers = mine[frames.trajectories[mine] == name]
            moved = frames.displacements(numbers)
            deepest = int(np.linalg.norm(moved, axis=2).max(axis=1).argmax())
            picture = frames.pictures(numbers[deepest : deepest + 1])[0]
            touches.append(Touch(picture, frames.background(sensor), moved[deepest]))
        if len(touches) > len(best):
            best = touches
        if len(best) >= LEAST_TOUCHES:
            break
    if not best:
        raise UsageError(f"no frame of sensor {sensor!r} in any part of the table", "touches to calibrate on", "")
    return best


def taxim_published(recipe_run: RecipeRun) -> OpticalMethod:
    """Taxim with the published DIGIT table and the nominal camera, on the recipe's mesh."""
    return taxim_method.taxim_published(surface_of(recipe_run))


def taxim_registered(recipe_run: RecipeRun) -> PerUnit:
    """Taxim with the published DIGIT table, seen through a camera that is registered for each unit."""
    return PerUnit("taxim_registered", recipe_run, taxim_method.taxim_registered)


def taxim_calibrated(recipe_run: RecipeRun) -> PerUnit:
    """Taxim, registered and calibrated for each unit of a recipe's store."""
    return PerUnit("taxim_calibrated", recipe_run, taxim_method.taxim_calibrated)


def fots_published(recipe_run: RecipeRun) -> OpticalMethod:
    """FOTS with a network trained on the published DIGIT table and the nominal camera, on the recipe's mesh."""
    return fots.fots_published(surface_of(recipe_run))


def fots_calibrated(recipe_run: RecipeRun) -> PerUnit:
    """FOTS, registered and calibrated for each unit of a recipe's store."""
    return PerUnit("fots_calibrated", recipe_run, fots.fots_calibrated)


def across(recipe_run: RecipeRun) -> AcrossMethod:
    """ACROSS: the recipe's mesh VAE, and Taxim with the published table."""
    return AcrossMethod(recipe_run.mesh_vae, taxim_published(recipe_run))
