"""Taxim as a baseline: as published, through a registered camera, and calibrated on the unit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from split_models.methods.optical_method import OpticalMethod, calibrated
from tactiledata.optics.registration import Touch
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.taxim import published_digit_table
from tactiledata.optics.taxim_calibration import calibrate
from tactiledata.optics.view import View
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.digit import DIGIT


def taxim_published(surface: GelSurface, sensor: Sensor = DIGIT, table: Path | None = None) -> OpticalMethod:
    """Taxim with the published DIGIT table and the nominal camera; of the unit it takes only the background.

    Parameters
    ----------
    surface : GelSurface
        Surface of the mesh that displacements belong to.
    sensor : Sensor
        Sensor with the nominal camera.
    table : Path, optional
        Another published table in Taxim's file format.
    """
    return OpticalMethod("taxim_published", surface, View.nominal(sensor), published_digit_table(table).change)


def taxim_registered(surface: GelSurface, view: View, touches: Sequence[Touch]) -> OpticalMethod:
    """Taxim with the published DIGIT table, seen through the unit's registered camera.

    It parts what a misplaced camera costs from what another unit's colours cost.

    Parameters
    ----------
    surface : GelSurface
        Surface of the mesh that displacements belong to.
    view : View
        The unit's registered camera.
    touches : sequence of Touch
        Not used: the table stays as it was published.
    """
    return OpticalMethod("taxim_registered", surface, view, published_digit_table().change)


def taxim_calibrated(surface: GelSurface, view: View, touches: Sequence[Touch]) -> OpticalMethod:
    """Taxim with a table and shadows that are fitted to touches of the unit, seen through its registered camera.

    Parameters
    ----------
    surface : GelSurface
        Surface of the mesh that displacements belong to.
    view : View
        The unit's registered camera.
    touches : sequence of Touch
        Touches of the unit with their meshes.

    Raises
    ------
    UsageError
        There is no touch, or none that shows a contact.
    """
    return calibrated(
        "taxim_calibrated",
        surface,
        view,
        touches,
        lambda presses: calibrate(presses, "touches of the unit").change,
        is_planar=False,
    )
